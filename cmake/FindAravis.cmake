# Aravis::Aravis, with what it takes from GLib. Its own .pc file cannot be used: it asks for that of libusb, which
# Debian's libaravis-dev does not bring.
include(FindPackageHandleStandardArgs)
find_package(PkgConfig QUIET)
if(PKG_CONFIG_FOUND)
  pkg_check_modules(ARAVIS_GLIB QUIET IMPORTED_TARGET gio-2.0 gobject-2.0 glib-2.0)
endif()
find_path(ARAVIS_INCLUDE_DIR arv.h PATH_SUFFIXES aravis-0.8)
find_library(ARAVIS_LIBRARY aravis-0.8)
find_package_handle_standard_args(Aravis REQUIRED_VARS ARAVIS_LIBRARY ARAVIS_INCLUDE_DIR ARAVIS_GLIB_FOUND)
if(Aravis_FOUND AND NOT TARGET Aravis::Aravis)
  add_library(Aravis::Aravis UNKNOWN IMPORTED)
  set_target_properties(Aravis::Aravis PROPERTIES IMPORTED_LOCATION "${ARAVIS_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${ARAVIS_INCLUDE_DIR}" INTERFACE_LINK_LIBRARIES PkgConfig::ARAVIS_GLIB)
endif()
