# Debian 12's libopenimageio-dev ships a package file that fails unless openimageio-tools is installed too (its
# targets name /usr/bin/iconvert), so headers and libraries are looked for directly. Defines OpenImageIO::OpenImageIO.
find_path(OpenImageIO_INCLUDE_DIR OpenImageIO/imageio.h)
find_library(OpenImageIO_LIBRARY OpenImageIO)
find_library(OpenImageIO_UTIL_LIBRARY OpenImageIO_Util)
if(OpenImageIO_INCLUDE_DIR)
  file(STRINGS "${OpenImageIO_INCLUDE_DIR}/OpenImageIO/oiioversion.h" lines REGEX "#define OIIO_VERSION_(MAJOR|MINOR|PATCH) ")
  list(TRANSFORM lines REPLACE "[^0-9]" "")
  string(REPLACE ";" "." OpenImageIO_VERSION "${lines}")
endif()
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OpenImageIO
  REQUIRED_VARS OpenImageIO_LIBRARY OpenImageIO_UTIL_LIBRARY OpenImageIO_INCLUDE_DIR
  VERSION_VAR OpenImageIO_VERSION)
if(OpenImageIO_FOUND AND NOT TARGET OpenImageIO::OpenImageIO)
  add_library(OpenImageIO::OpenImageIO INTERFACE IMPORTED)
  set_target_properties(OpenImageIO::OpenImageIO PROPERTIES
    INTERFACE_INCLUDE_DIRECTORIES "${OpenImageIO_INCLUDE_DIR}"
    INTERFACE_LINK_LIBRARIES "${OpenImageIO_LIBRARY};${OpenImageIO_UTIL_LIBRARY}")
endif()
mark_as_advanced(OpenImageIO_INCLUDE_DIR OpenImageIO_LIBRARY OpenImageIO_UTIL_LIBRARY)
