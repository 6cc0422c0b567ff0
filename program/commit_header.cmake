# Writes a header that defines VIEWPEEL_COMMIT as the commit of a source tree, such as " (commit 1a2b3c4d5e)".
#   cmake -DSOURCE=... -DHEADER=... -P commit_header.cmake
if(EXISTS ${SOURCE}/.git)
  execute_process(COMMAND git -C ${SOURCE} rev-parse --short=10 HEAD OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
endif()
if(commit)
  set(commit " (commit ${commit})")
endif()
file(CONFIGURE OUTPUT ${HEADER} CONTENT "#define VIEWPEEL_COMMIT \"${commit}\"\n")
