# What `cmake --install` and `cpack` take: the program with its data (component rigcal), and the libraries of the rooms
# with their headers for find_package(rigcal) (component dev).

include(CMakePackageConfigHelpers)

set(doc_dir "${CMAKE_INSTALL_DATADIR}/doc/rigcal")
install(TARGETS rigcal RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}" COMPONENT rigcal)
install(DIRECTORY config/rigs config/scenes DESTINATION "${CMAKE_INSTALL_DATADIR}/rigcal" COMPONENT rigcal)
install(DIRECTORY udev DESTINATION "${CMAKE_INSTALL_DATADIR}/rigcal" COMPONENT rigcal USE_SOURCE_PERMISSIONS
  PATTERN post* EXCLUDE)
install(FILES udev/70-rigcal.rules DESTINATION lib/udev/rules.d COMPONENT rigcal)
install(FILES udev/rigcal-capture@.service DESTINATION lib/systemd/system COMPONENT rigcal)
install(FILES udev/sysctl.conf DESTINATION lib/sysctl.d RENAME 10-rigcal.conf COMPONENT rigcal)
install(FILES udev/modprobe.conf DESTINATION lib/modprobe.d RENAME rigcal.conf COMPONENT rigcal)
install(FILES udev/tmpfiles.conf DESTINATION lib/tmpfiles.d RENAME rigcal.conf COMPONENT rigcal)
install(DIRECTORY docs/schema DESTINATION "${CMAKE_INSTALL_DATADIR}/rigcal" COMPONENT rigcal)
# All pages, in the tree's own places: they point to each other.
install(FILES README.md CONTRIBUTING.md CHANGELOG.md LICENSE DESTINATION "${doc_dir}" COMPONENT rigcal)
install(DIRECTORY docs DESTINATION "${doc_dir}" COMPONENT rigcal)
install(FILES cmake/copyright "${RIGCAL_PAGES}/changelog.gz" DESTINATION "${doc_dir}" COMPONENT rigcal)
install(FILES cmake/copyright "${RIGCAL_PAGES}/changelog.gz" DESTINATION "${doc_dir}-dev" COMPONENT dev)

install(DIRECTORY apps core drivers simdata DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/rigcal" COMPONENT dev
  FILES_MATCHING PATTERN "*.h" PATTERN pages EXCLUDE)
set(config_dir "${CMAKE_INSTALL_LIBDIR}/cmake/rigcal")
install(EXPORT rigcal NAMESPACE rigcal:: FILE rigcalTargets.cmake DESTINATION "${config_dir}" COMPONENT dev)
configure_package_config_file(cmake/rigcalConfig.cmake.in "${CMAKE_BINARY_DIR}/rigcalConfig.cmake"
  INSTALL_DESTINATION "${config_dir}")
write_basic_package_version_file("${CMAKE_BINARY_DIR}/rigcalConfigVersion.cmake" COMPATIBILITY SameMinorVersion)
install(FILES "${CMAKE_BINARY_DIR}/rigcalConfig.cmake" "${CMAKE_BINARY_DIR}/rigcalConfigVersion.cmake"
  cmake/FindAravis.cmake
  DESTINATION "${config_dir}" COMPONENT dev)

# cpack -G DEB in the build folder makes rigcal_*.deb and rigcal-dev_*.deb.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME rigcal)
set(CPACK_PACKAGE_VENDOR rigcal)
set(CPACK_PACKAGE_CONTACT "the maintainers of rigcal <maintainers@rigcal.example>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL rigcal dev)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_RIGCAL_PACKAGE_CONTROL_EXTRA "${CMAKE_SOURCE_DIR}/udev/postinst;${CMAKE_SOURCE_DIR}/udev/postrm")
set(CPACK_DEBIAN_RIGCAL_PACKAGE_NAME rigcal)
# Without it CPack leaves the list of libraries empty, and says so in a line that nobody reads.
find_program(RIGCAL_DPKG_SHLIBDEPS dpkg-shlibdeps)
if(RIGCAL_DPKG_SHLIBDEPS)
  set(CPACK_DEBIAN_RIGCAL_PACKAGE_SHLIBDEPS ON)
elseif(EXISTS /etc/debian_version)
  message(WARNING "there is no dpkg-shlibdeps (package dpkg-dev): a .deb made of this build would not name its libraries")
endif()
set(CPACK_COMPONENT_RIGCAL_DESCRIPTION
"From one recording of a rig on a turntable, without targets and without a
trajectory, rigcal finds where its LiDARs sit, and says for each of them
whether the answer can be trusted.")
set(CPACK_DEBIAN_DEV_PACKAGE_NAME rigcal-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
string(CONCAT CPACK_DEBIAN_DEV_PACKAGE_DEPENDS
  "libaravis-dev, libcli11-dev, libeigen3-dev, libfmt-dev, libtbb-dev, libyaml-cpp-dev, "
  "liblz4-dev, liblzf-dev, libbz2-dev, libceres-dev, libgpiod-dev, "
  "libjpeg-dev, libmicrohttpd-dev, libopencv-calib3d-dev, libopencv-core-dev, libopencv-features2d-dev, "
  "libopencv-imgproc-dev, libpng-dev, "
  "libssl-dev, nlohmann-json3-dev, pkg-config, zlib1g-dev")
if(RIGCAL_OPENCV_ARUCO_LIBRARY MATCHES "opencv_aruco")
  string(APPEND CPACK_DEBIAN_DEV_PACKAGE_DEPENDS ", libopencv-contrib-dev")
elseif(RIGCAL_OPENCV_ARUCO_LIBRARY MATCHES "opencv_objdetect")
  string(APPEND CPACK_DEBIAN_DEV_PACKAGE_DEPENDS ", libopencv-objdetect-dev")
endif()
set(CPACK_COMPONENT_DEV_DESCRIPTION
"Headers and static libraries of rigcal, for find_package(rigcal): what the
program does, from C++.")
include(CPack)
