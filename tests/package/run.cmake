# Installs the build to a staging folder, then builds and runs tests/package against it.
# Needs: BUILD_DIR, SOURCE_DIR (of tests/package), CXX, GENERATOR.
set(stage "${BUILD_DIR}/package-stage")
set(consumer "${BUILD_DIR}/package-consumer")
file(REMOVE_RECURSE "${stage}" "${consumer}")

function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "failed (${status}): ${ARGN}\n${output}")
  endif()
endfunction()

run("${CMAKE_COMMAND}" --install "${BUILD_DIR}" --prefix "${stage}")
run("${CMAKE_COMMAND}" -S "${SOURCE_DIR}" -B "${consumer}" -G "${GENERATOR}" "-DCMAKE_CXX_COMPILER=${CXX}"
    "-DCMAKE_PREFIX_PATH=${stage}")
run("${CMAKE_COMMAND}" --build "${consumer}")
run("${consumer}/package_test")
