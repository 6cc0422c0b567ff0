// Linked into what sanitizers watch: libraries stay loaded, or leaks in a driver would have no name that
// tests/support/lsan.supp could tell.
extern "C" int dlclose(void*) { return 0; }
