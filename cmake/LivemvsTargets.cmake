# One folder, one target: helpers that give every target the same language level, warnings and numerics.

# Settings that every target of the project shares.
add_library(livemvs_settings INTERFACE)
target_compile_features(livemvs_settings INTERFACE cxx_std_20)
target_compile_options(livemvs_settings INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
  # Results must not depend on the instruction set: no contraction, no fast-math (docs/algorithm.md).
  -ffp-contract=off -fno-math-errno -fno-trapping-math)
if(LIVEMVS_WERROR)
  target_compile_options(livemvs_settings INTERFACE -Werror)
endif()
if(LIVEMVS_SANITIZE)
  target_compile_options(livemvs_settings INTERFACE -fsanitize=${LIVEMVS_SANITIZE} -fno-omit-frame-pointer
                         -fno-sanitize-recover=all)
  target_link_options(livemvs_settings INTERFACE -fsanitize=${LIVEMVS_SANITIZE})
endif()

# livemvs_add_module(<name> SOURCES ... [DEPENDS ...] [PRIVATE_DEPENDS ...] [TESTS ...] [TEST_DEPENDS ...])
#
# Adds the library livemvs_<name> (alias livemvs::<name>) and, with TESTS, the test program <name>_test.
function(livemvs_add_module name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS;PRIVATE_DEPENDS;TESTS;TEST_DEPENDS" ${ARGN})
  add_library(livemvs_${name} STATIC ${ARG_SOURCES})
  add_library(livemvs::${name} ALIAS livemvs_${name})
  target_include_directories(livemvs_${name} PUBLIC "${PROJECT_SOURCE_DIR}/src")
  target_link_libraries(livemvs_${name} PUBLIC ${ARG_DEPENDS} PRIVATE livemvs_settings ${ARG_PRIVATE_DEPENDS})
  if(LIVEMVS_BUILD_TESTS AND ARG_TESTS)
    add_executable(${name}_test ${ARG_TESTS})
    target_link_libraries(${name}_test PRIVATE livemvs::${name} livemvs_settings ${ARG_PRIVATE_DEPENDS}
                          ${ARG_TEST_DEPENDS} GTest::gmock GTest::gtest_main)
    gtest_discover_tests(${name}_test DISCOVERY_TIMEOUT 60 PROPERTIES TIMEOUT 300)
  endif()
endfunction()
