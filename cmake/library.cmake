# libvoile.so with what finds it (CMake, pkg-config), and the Python binding.
add_library(voile_shared SHARED $<TARGET_OBJECTS:voile_interface>)
set_target_properties(voile_shared PROPERTIES OUTPUT_NAME voile VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR})
# What comes from archives is hidden, the instantiations of templates of the standard library among it.
target_link_options(voile_shared PRIVATE -Wl,--exclude-libs,ALL -Wl,--no-undefined -Wl,--as-needed)
target_link_libraries(voile_shared PRIVATE voile_core)
add_dependencies(voile_shared voile-gmsh voile-picture)

include(CMakePackageConfigHelpers)
set(VOILE_CMAKE_FOLDER ${CMAKE_INSTALL_LIBDIR}/cmake/Voile)
configure_package_config_file(cmake/VoileConfig.cmake.in ${CMAKE_BINARY_DIR}/VoileConfig.cmake INSTALL_DESTINATION ${VOILE_CMAKE_FOLDER}
                              PATH_VARS CMAKE_INSTALL_INCLUDEDIR CMAKE_INSTALL_LIBDIR)
write_basic_package_version_file(VoileConfigVersion.cmake COMPATIBILITY SameMinorVersion)
file(RELATIVE_PATH VOILE_TO_PREFIX /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
configure_file(cmake/voile.pc.in voile.pc @ONLY)
install(TARGETS voile_shared LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT voile NAMELINK_COMPONENT dev)
install(FILES ${CMAKE_BINARY_DIR}/VoileConfig.cmake ${CMAKE_BINARY_DIR}/VoileConfigVersion.cmake
        DESTINATION ${VOILE_CMAKE_FOLDER} COMPONENT dev)
install(FILES ${CMAKE_BINARY_DIR}/voile.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT dev)
file(GLOB VOILE_PUBLIC_HEADERS CONFIGURE_DEPENDS include/voile/*.hpp)
install(FILES ${VOILE_PUBLIC_HEADERS} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/voile COMPONENT dev)

# import voile works without the binding; voile.Simulation needs it.
find_package(pybind11 2.10 CONFIG QUIET)
if(NOT pybind11_FOUND OR NOT Python3_Development.Module_FOUND)
  message(STATUS "pybind11 is not there (packages pybind11-dev, python3-dev): voile.Simulation is left out")
  return()
endif()
pybind11_add_module(voile_python MODULE NO_EXTRAS src/python/core.cpp)
target_include_directories(voile_python SYSTEM PRIVATE ${PETSC_INCLUDE_DIRS})
target_include_directories(voile_python PRIVATE include)
target_compile_definitions(voile_python PRIVATE OMPI_SKIP_MPICXX)
target_link_libraries(voile_python PRIVATE voile_shared PkgConfig::PETSC MPI::MPI_CXX voile_options)
# With petsc4py residuals and tangents are its vectors and matrices.
execute_process(COMMAND ${Python3_EXECUTABLE} -c "import petsc4py; print(petsc4py.get_include())"
                OUTPUT_VARIABLE VOILE_PETSC4PY OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(VOILE_PETSC4PY)
  target_include_directories(voile_python SYSTEM PRIVATE ${VOILE_PETSC4PY})
  target_compile_definitions(voile_python PRIVATE VOILE_PETSC4PY)
endif()
# A package in the folder of the build, as it is installed.
file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/python/voile)
file(GLOB VOILE_PYTHON_FILES CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/python/voile/*.py)
foreach(file ${VOILE_PYTHON_FILES})
  get_filename_component(name ${file} NAME)
  file(CREATE_LINK ${file} ${CMAKE_BINARY_DIR}/python/voile/${name} SYMBOLIC)
endforeach()
file(RELATIVE_PATH VOILE_TO_LIBRARY /${VOILE_PYTHON_FOLDER}/voile /${CMAKE_INSTALL_LIBDIR})
set_target_properties(voile_python PROPERTIES OUTPUT_NAME _core LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/python/voile
                                              INSTALL_RPATH "$ORIGIN/${VOILE_TO_LIBRARY}")
install(TARGETS voile_python LIBRARY DESTINATION ${VOILE_PYTHON_FOLDER}/voile COMPONENT python3)
