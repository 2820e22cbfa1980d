# cmake --install: the executables, the library with its headers, and a package file, so that
# find_package(Irradia) and target_link_libraries(... Irradia::irradia_render) work elsewhere.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
include(EmbedKernels)
include(CompileKernels)

if(NOT IRRADIA_MINIMAL)  # where they find libirradia_exr.so and libirradia_oiio.so
  file(RELATIVE_PATH to_libraries "${CMAKE_INSTALL_FULL_BINDIR}" "${CMAKE_INSTALL_FULL_LIBDIR}")
  set_target_properties(render compare PROPERTIES INSTALL_RPATH "$ORIGIN/${to_libraries}")
endif()
install(TARGETS render RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}")
if(NOT IRRADIA_MINIMAL)
  irradia_compile_kernels(render)
  install(TARGETS compare RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}")
  install(TARGETS irradia_oiio irradia_exr LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}")
  set(package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/Irradia")
  install(TARGETS irradia_options irradia_device irradia_core irradia_camera irradia_records irradia_cache irradia_render irradia_scene irradia_accel
                  irradia_image irradia_pictures
          EXPORT IrradiaTargets ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}")
  install(DIRECTORY include/irradia DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}")
  install(EXPORT IrradiaTargets NAMESPACE Irradia:: DESTINATION "${package_dir}")
  get_directory_property(embree_VERSION_MAJOR DIRECTORY src/accel DEFINITION embree_VERSION_MAJOR)
  configure_package_config_file(cmake/IrradiaConfig.cmake.in "${CMAKE_CURRENT_BINARY_DIR}/IrradiaConfig.cmake"
                                INSTALL_DESTINATION "${package_dir}" PATH_VARS CMAKE_INSTALL_LIBDIR)
  write_basic_package_version_file("${CMAKE_CURRENT_BINARY_DIR}/IrradiaConfigVersion.cmake"
                                   COMPATIBILITY SameMinorVersion)
  install(FILES "${CMAKE_CURRENT_BINARY_DIR}/IrradiaConfig.cmake"
                "${CMAKE_CURRENT_BINARY_DIR}/IrradiaConfigVersion.cmake"
          DESTINATION "${package_dir}")
endif()
