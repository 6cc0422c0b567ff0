/* This is the interface for C and languages that call C. The shared library viewpeel_c exports these functions alone.
 *
 * Scenes and results are opaque and freed by their caller. A function that can fail returns a status; on failure it
 * sets no output, and viewpeel_last_error gives the reason in one line. No exception leaves a function. Strings are
 * UTF-8 and end in 0; returned strings belong to their scene or result. Different threads may use one scene or result
 * at once. */
#ifndef VIEWPEEL_C_H
#define VIEWPEEL_C_H

#include <stddef.h>
#include <stdint.h>

#if defined(__GNUC__)
#define VIEWPEEL_API __attribute__((visibility("default")))
#else
#define VIEWPEEL_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

typedef struct viewpeel_scene viewpeel_scene;
typedef struct viewpeel_result viewpeel_result;

/* These are the codes of viewpeel::ErrorCode, and two more. */
typedef enum viewpeel_status {
  VIEWPEEL_OK = 0,
  VIEWPEEL_BAD_INPUT = 1, /* a file or array says something that is not a scene, or not a result */
  VIEWPEEL_BAD_USAGE = 2, /* options contradict themselves, or an argument is missing or out of range */
  VIEWPEEL_DEVICE = 3,    /* no Vulkan device can be used */
  VIEWPEEL_MEMORY = 4,
  VIEWPEEL_OUTPUT = 5, /* a file cannot be written */
  VIEWPEEL_LIMIT = 6,  /* more than the library can count or hold */
  VIEWPEEL_CHECK = 7,  /* results contradict a check */
  VIEWPEEL_STOPPED = 8 /* should_stop ended the run before there were two replicates */
} viewpeel_status;

/* These take the place of a second row, for radiation that leaves the scene, and radiation that ends on a back. */
#define VIEWPEEL_ENVIRONMENT 0xFFFFFFFEu
#define VIEWPEEL_LEAK 0xFFFFFFFFu

/* Options say what to compute. 0 is the default of each: `viewpeel_options options = {0};`. */
typedef struct viewpeel_options {
  double tolerance;      /* largest error; the default goal where none is given */
  double relative;       /* largest standard error as a share of its form factor */
  double seconds;        /* time limit, s */
  double epsilon, delta; /* a guarantee: within epsilon with probability 1 - delta (0: 0.01) */
  int by_surface;        /* rows are surfaces, not polygons */
  int two_sided;         /* both sides emit and receive */
  uint32_t threads;      /* 0: one for each core */
  uint64_t seed;         /* 0 counts as 1 */
  /* The run calls it often, from any thread, and ends if it returns a value other than 0. It may be NULL. */
  int (*should_stop)(void* context);
  void* context;
  int promise; /* the tolerance, as viewpeel::Request::promise. 0: where it costs little; 1: on; -1: off */
  double rms;  /* root mean square of the errors of all form factors; a goal of its own */
} viewpeel_options;

/* Rows are compressed sparse rows of form factors: entries of row i are from starts[i] to starts[i + 1] - 1. */
typedef struct viewpeel_rows {
  size_t row_count, entry_count;
  const int64_t* starts;  /* row_count + 1 */
  const int32_t* columns; /* entry_count, as the two below */
  const double *form_factors, *standard_errors;
  const double *lower, *upper; /* intervals of a guarantee; else NULL */
} viewpeel_rows;

/* Returns the message of the latest failure on this thread; "" before any. It stays valid until the next failure. */
VIEWPEEL_API const char* viewpeel_last_error(void);
/* Returns the library's version: "0.2.0". */
VIEWPEEL_API const char* viewpeel_version(void);

/* Reads a scene, as viewpeel::loadScene.
 *   In: file: its kind follows from its name, as docs/formats.md says    Out: scene, to be freed
 *   Error: corners to 1 ulp of the unit ball. Tests: tests/c.
 *   Returns: BAD_INPUT.    Cost: O(corners log corners). */
VIEWPEEL_API viewpeel_status viewpeel_load_scene(const char* file, viewpeel_scene** scene);
/* Reads several files into one scene, each with some of its parts, as viewpeel::loadScene for several files.
 *   In: files: file_count names    Out, Error, Cost: as viewpeel_load_scene.
 *   Returns: BAD_INPUT; BAD_USAGE for no file, a file that is named twice, or a format that is a whole scene. */
VIEWPEEL_API viewpeel_status viewpeel_load_scene_files(const char* const* files, size_t file_count,
                                                       viewpeel_scene** scene);
/* Makes a scene of arrays, as viewpeel::buildScene.
 *   In: points: 3 x point_count coordinates, in any unit; corners: indices of points from 0, polygon after polygon,
 *     counter-clockwise seen from the front; starts: polygon_count + 1, corners of polygon k are from starts[k] to
 *     starts[k + 1]; surface_names: polygon_count, or NULL for one surface
 *   Out, Error, Returns, Cost: as viewpeel_load_scene. */
VIEWPEEL_API viewpeel_status viewpeel_build_scene(const double* points, size_t point_count, const uint32_t* corners,
                                                  const size_t* starts, size_t polygon_count,
                                                  const char* const* surface_names, viewpeel_scene** scene);
/* Frees a scene; results do not need it.    In: NULL does nothing. */
VIEWPEEL_API void viewpeel_free_scene(viewpeel_scene* scene);

/* Computes the form factors F_ij of all pairs, as viewpeel::computeFormFactors.
 *   In: options: NULL for the defaults    Out: result, to be freed
 *   Error: as the goal demands.    Returns: BAD_USAGE, DEVICE, MEMORY, LIMIT, STOPPED.
 *   Cost: as computeFormFactors. */
VIEWPEEL_API viewpeel_status viewpeel_compute(const viewpeel_scene* scene, const viewpeel_options* options,
                                              viewpeel_result** result);
/* Reads a .h5 of results, as viewpeel::readResult.    Returns: BAD_INPUT. */
VIEWPEEL_API viewpeel_status viewpeel_read_result(const char* file, viewpeel_result** result);
/* Writes .csv, .mtx, .npz, .h5, .vtp, .vwf or .html by the file's end; .vtp only of results that were computed.
 *   Returns: BAD_USAGE, OUTPUT. */
VIEWPEEL_API viewpeel_status viewpeel_write_result(const viewpeel_result* result, const char* file);
/* Frees a result, and the arrays and names that came from it.    In: NULL does nothing. */
VIEWPEEL_API void viewpeel_free_result(viewpeel_result* result);

/* Returns all form factors between rows; arrays belong to the result.    Cost: O(1). */
VIEWPEEL_API viewpeel_rows viewpeel_get_rows(const viewpeel_result* result);
/* Returns the name of a row, NULL where there is no such row.    Cost: O(1). */
VIEWPEEL_API const char* viewpeel_row_name(const viewpeel_result* result, size_t row);
/* Returns the emitting area of a row, input units squared; 0 for an empty row, or none.    Cost: O(1). */
VIEWPEEL_API double viewpeel_row_area(const viewpeel_result* result, size_t row);
/* Gives F from row i to row j, or to VIEWPEEL_ENVIRONMENT or VIEWPEEL_LEAK.
 *   Out: standard_error: may be NULL    Returns: BAD_USAGE for rows that are not there.    Cost: O(log entries). */
VIEWPEEL_API viewpeel_status viewpeel_form_factor(const viewpeel_result* result, size_t i, size_t j,
                                                  double* form_factor, double* standard_error);

#ifdef __cplusplus
}
#endif

#endif
