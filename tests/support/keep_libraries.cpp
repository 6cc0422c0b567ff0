// Programs under a sanitizer link this file, which keeps libraries loaded. Otherwise leaks in a driver would have no
// name that tests/support/lsan.supp could match.
extern "C" int dlclose(void*) { return 0; }
