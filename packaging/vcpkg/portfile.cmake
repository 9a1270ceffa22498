# SPDX-License-Identifier: MIT
# The library alone, which needs nothing but a C compiler.
vcpkg_download_distfile(
    archive
    URLS "https://example.com/libntp/releases/download/v${VERSION}/libntp-${VERSION}.tar.gz"
    FILENAME "libntp-${VERSION}.tar.gz"
    SHA512 0
)
vcpkg_extract_source_archive(source ARCHIVE "${archive}")
vcpkg_configure_meson(
    SOURCE_PATH "${source}"
    OPTIONS -Dio=disabled -Dcli=disabled -Dgegl=disabled -Dgimp=disabled -Dtests=false
)
vcpkg_install_meson()
vcpkg_fixup_pkgconfig()
vcpkg_copy_pdbs()
if(VCPKG_LIBRARY_LINKAGE STREQUAL "static")
    # On Windows a program would otherwise look for the names of a DLL.
    vcpkg_replace_string(
        "${CURRENT_PACKAGES_DIR}/include/libntp.h" "#if defined(NTP_STATIC)" "#if 1"
    )
endif()
file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/debug/include")
file(INSTALL "${CMAKE_CURRENT_LIST_DIR}/usage" DESTINATION "${CURRENT_PACKAGES_DIR}/share/${PORT}")
vcpkg_install_copyright(FILE_LIST "${source}/LICENSE")
