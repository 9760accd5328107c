# One folder, one target: helpers that give every target the same language level, warnings and numerics.

# Settings that every target of the project shares.
add_library(livemvs_settings INTERFACE)
target_compile_features(livemvs_settings INTERFACE cxx_std_20)
target_compile_options(livemvs_settings INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
  # {.path = p} leaves the other fields at their defaults, which is what it is for.
  -Wno-missing-field-initializers
  # GCC 12 sees overlapping copies in "text" + std::string (its bug 105651).
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>
  # In unity builds it takes the sources for headers, whose types must not hold unnamed namespaces' types.
  $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>
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

# livemvs_add_module(<name> SOURCES ... [HEADERS ...] [DEPENDS ...] [PRIVATE_DEPENDS ...] [TESTS ...]
#                    [TEST_DEPENDS ...])
#
# Adds the library livemvs_<name> (alias livemvs::<name>) and, with TESTS, the test program <name>_test. HEADERS are the
# module's public headers: those that are installed.
function(livemvs_add_module name)
  cmake_parse_arguments(ARG "" "" "SOURCES;HEADERS;DEPENDS;PRIVATE_DEPENDS;TESTS;TEST_DEPENDS" ${ARGN})
  add_library(livemvs_${name} STATIC ${ARG_SOURCES})
  add_library(livemvs::${name} ALIAS livemvs_${name})
  target_sources(livemvs_${name} PUBLIC FILE_SET HEADERS BASE_DIRS "${PROJECT_SOURCE_DIR}/src" FILES ${ARG_HEADERS})
  target_include_directories(livemvs_${name} PUBLIC "$<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/src>")
  target_compile_features(livemvs_${name} PUBLIC cxx_std_20)
  # What is only compiled in does not concern who links the installed library.
  set(private_links "$<BUILD_INTERFACE:livemvs_settings>")
  foreach(dependency IN LISTS ARG_PRIVATE_DEPENDS)
    if(dependency MATCHES "nlohmann_json|nanoflann|livemvs::parallel")
      set(dependency "$<BUILD_INTERFACE:${dependency}>")
    endif()
    list(APPEND private_links "${dependency}")
  endforeach()
  target_link_libraries(livemvs_${name} PUBLIC ${ARG_DEPENDS} PRIVATE ${private_links})
  set_target_properties(livemvs_${name} PROPERTIES EXPORT_NAME ${name})
  install(TARGETS livemvs_${name} EXPORT livemvs ARCHIVE COMPONENT development FILE_SET HEADERS COMPONENT development)
  if(LIVEMVS_BUILD_TESTS AND ARG_TESTS)
    add_executable(${name}_test ${ARG_TESTS})
    target_link_libraries(${name}_test PRIVATE livemvs::${name} livemvs_settings ${ARG_PRIVATE_DEPENDS}
                          ${ARG_TEST_DEPENDS} GTest::gmock GTest::gtest_main)
    set(environment "")
    if(LIVEMVS_EMULATES_CUDA AND name MATCHES "^(backend|pipeline)$")
      set(environment ENVIRONMENT LIVEMVS_EMULATED_GPU=4096)
    endif()
    gtest_discover_tests(${name}_test NO_PRETTY_VALUES DISCOVERY_TIMEOUT 60 PROPERTIES TIMEOUT 900 ${environment})
  endif()
endfunction()
