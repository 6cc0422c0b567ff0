// Programs under a sanitizer link this file: libraries stay loaded, or leaks in a driver would have no name for
// tests/support/lsan.supp.
extern "C" int dlclose(void*) { return 0; }
