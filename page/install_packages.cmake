# This script installs the packages of the lock file: cmake -DNPM=npm -DWORK=FOLDER [-DOMIT=--omit=dev] -P
# install_packages.cmake
execute_process(COMMAND ${NPM} ci --ignore-scripts ${OMIT} WORKING_DIRECTORY ${WORK} RESULT_VARIABLE failure OUTPUT_QUIET ERROR_VARIABLE reason)
if(failure)
  file(WRITE ${WORK}/npm.log "${reason}")
  message(FATAL_ERROR "npm cannot install the page's packages (${WORK}/npm.log says why); without a network, build without the page: cmake -DVIEWPEEL_BUILD_REPORT=OFF")
endif()
file(TOUCH ${WORK}/packages.stamp)
