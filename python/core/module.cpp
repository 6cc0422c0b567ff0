// This file defines viewpeel._core, the compiled part of the Python module. Its types are in viewpeel/_core.pyi.
#include "python/core/bindings.h"

#include <viewpeel/error.h>

namespace viewpeel::python {
namespace {

// Raises the Python exception that users expect for each code of the library's Error.
void translate(const Error& error, const py::object& other) {
  switch (error.code()) {
    case ErrorCode::bad_input:
    case ErrorCode::bad_usage:
      return PyErr_SetString(PyExc_ValueError, error.what());
    case ErrorCode::memory:
      return PyErr_SetString(PyExc_MemoryError, error.what());
    case ErrorCode::output:
      return PyErr_SetString(PyExc_OSError, error.what());
    case ErrorCode::device:
    case ErrorCode::limit:
    case ErrorCode::check:
      return PyErr_SetString(other.ptr(), error.what());
  }
}

}  // namespace
}  // namespace viewpeel::python

PYBIND11_MODULE(_core, module) {
  using namespace viewpeel::python;
  module.doc() = "The compiled part of viewpeel; use the functions of viewpeel itself.";
  module.attr("__version__") = VIEWPEEL_VERSION;
  static py::exception<viewpeel::Error> other(module, "Error", PyExc_RuntimeError);
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const viewpeel::Error& error) {
      translate(error, other);
    }
  });
  addScene(module);
  addResult(module);
  addRun(module);
  addEnvironment(module);
  addHeat(module);
}
