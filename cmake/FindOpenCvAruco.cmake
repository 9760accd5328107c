# The parts of OpenCV that track a board: aruco (of the contrib modules), calib3d, imgproc and core, as the imported
# target OpenCvAruco::aruco. Debian's own OpenCVConfig.cmake comes with a package that needs every module, VTK among them.
find_path(OpenCvAruco_INCLUDE_DIR opencv2/aruco.hpp PATH_SUFFIXES opencv4)
set(OpenCvAruco_required OpenCvAruco_INCLUDE_DIR)
foreach(part aruco calib3d imgproc core)
  find_library(OpenCvAruco_${part}_LIBRARY opencv_${part})
  list(APPEND OpenCvAruco_required OpenCvAruco_${part}_LIBRARY)
endforeach()
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OpenCvAruco REQUIRED_VARS ${OpenCvAruco_required}
  REASON_FAILURE_MESSAGE "install libopencv-contrib-dev (scripts/setup does)")
if(OpenCvAruco_FOUND AND NOT TARGET OpenCvAruco::aruco)
  add_library(OpenCvAruco::aruco INTERFACE IMPORTED)
  target_include_directories(OpenCvAruco::aruco SYSTEM INTERFACE "${OpenCvAruco_INCLUDE_DIR}")
  target_link_libraries(OpenCvAruco::aruco INTERFACE "${OpenCvAruco_aruco_LIBRARY}" "${OpenCvAruco_calib3d_LIBRARY}"
    "${OpenCvAruco_imgproc_LIBRARY}" "${OpenCvAruco_core_LIBRARY}")
endif()
mark_as_advanced(${OpenCvAruco_required})
