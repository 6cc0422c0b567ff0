# Installs the build into an empty folder, builds the program in tests/consumer against it, and runs it. The library's
# one call and the program have to write the same bytes.
file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})
function(run)
  execute_process(COMMAND ${ARGN} WORKING_DIRECTORY ${WORK} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
  message("${output}")
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "failed with ${status}: ${ARGN}")
  endif()
endfunction()
set(link_flags)
if(FLAGS)
  set(link_flags -DCMAKE_EXE_LINKER_FLAGS=-fsanitize=${FLAGS})
endif()
run(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${WORK}/installed)
run(${CMAKE_COMMAND} -G Ninja -S ${CONSUMER} -B ${WORK}/build -DCMAKE_PREFIX_PATH=${WORK}/installed -DCMAKE_BUILD_TYPE=Release ${link_flags})
run(${CMAKE_COMMAND} --build ${WORK}/build)

# Only the public headers are installed.
file(GLOB_RECURSE headers RELATIVE ${WORK}/installed/include ${WORK}/installed/include/*)
list(LENGTH headers count)
list(FILTER headers EXCLUDE REGEX "^viewpeel/[a-z_]+[.]h$")
if(headers OR count GREATER 21)
  message(FATAL_ERROR "installed beside the public headers: ${headers}, ${count} in all")
endif()

# The man page is installed, and completion for three shells.
foreach(text man/man1/viewpeel.1 bash-completion/completions/viewpeel zsh/site-functions/_viewpeel fish/vendor_completions.d/viewpeel.fish)
  file(STRINGS ${WORK}/installed/share/${text} options REGEX "tolerance")
  if(NOT options)
    message(FATAL_ERROR "${text} is not installed, or has no option --tolerance")
  endif()
endforeach()

# The program's second name takes the place of View3D, which writes its log where it runs.
file(WRITE ${WORK}/plates.vs3 "F 3\nV 1 0 0 0\nV 2 1 0 0\nV 3 1 1 0\nV 4 0 1 0\nV 5 0 0 1\nV 6 1 0 1\nV 7 1 1 1\nV 8 0 1 1\n"
  "S 1 1 2 3 4 0 0 .9 low\nS 2 8 7 6 5 0 0 .9 high\nEnd\n")
run(${WORK}/installed/bin/view3d plates.vs3 plates.txt)
file(STRINGS ${WORK}/plates.txt lines)
list(GET lines 2 row)
if(NOT row STREQUAL "0.000000 0.199825" OR NOT EXISTS ${WORK}/View3D.log)
  message(FATAL_ERROR "view3d has written '${row}' for two opposite squares")
endif()

# A plan depends on measured times, so the program gets the options of the consumer's plan.
execute_process(COMMAND ${WORK}/build/consumer ${SCENE} ${WORK}/consumer.csv OUTPUT_VARIABLE plan RESULT_VARIABLE status)
if(NOT status EQUAL 0)
  message(FATAL_ERROR "consumer failed with ${status}")
endif()
separate_arguments(plan)
run(${WORK}/installed/bin/viewpeel compute ${SCENE} ${plan} --tolerance 1e-3 -o ${WORK}/program.csv)
run(${CMAKE_COMMAND} -E compare_files ${WORK}/consumer.csv ${WORK}/program.csv)
# Without any options the program writes the same bytes, too. This scene is sampled by pair lines, whose plan does not
# depend on measured times.
run(${WORK}/installed/bin/viewpeel compute ${SCENE} -o ${WORK}/default.csv)
run(${CMAKE_COMMAND} -E compare_files ${WORK}/consumer.csv ${WORK}/default.csv)
# Negative control: another seed gives another result.
run(${WORK}/installed/bin/viewpeel compute ${SCENE} ${plan} --tolerance 1e-3 --seed 2 --quiet -o ${WORK}/other.csv)
execute_process(COMMAND ${CMAKE_COMMAND} -E compare_files ${WORK}/consumer.csv ${WORK}/other.csv RESULT_VARIABLE differs ERROR_QUIET)
if(NOT differs)
  message(FATAL_ERROR "another seed has given the same bytes")
endif()
