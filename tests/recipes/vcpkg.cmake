# SPDX-License-Identifier: MIT
# Runs a portfile without vcpkg: cmake -DPORTFILE=FILE -DARCHIVE=FILE -DVERSION=V -DWORK=DIR
#     -DVCPKG_LIBRARY_LINKAGE=static|dynamic -P vcpkg.cmake
# Each function does what vcpkg's does, of what the portfile asks of it, for one build type.
cmake_minimum_required(VERSION 3.20)
set(PORT libntp)
set(CURRENT_PACKAGES_DIR ${WORK}/package)

function(run)
    execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY OUTPUT_QUIET)
endfunction()

function(vcpkg_download_distfile out)
    cmake_parse_arguments(PARSE_ARGV 1 a "" "FILENAME;SHA512" "URLS")
    file(SHA512 ${ARCHIVE} found)
    get_filename_component(name ${ARCHIVE} NAME)
    get_filename_component(published ${a_URLS} NAME)
    if(NOT found STREQUAL a_SHA512 OR NOT name STREQUAL published OR NOT name STREQUAL a_FILENAME)
        message(FATAL_ERROR "${ARCHIVE} is not ${a_URLS} with SHA512 ${a_SHA512}")
    endif()
    set(${out} ${ARCHIVE} PARENT_SCOPE)
endfunction()

function(vcpkg_extract_source_archive out)
    cmake_parse_arguments(PARSE_ARGV 1 a "" "ARCHIVE" "")
    file(ARCHIVE_EXTRACT INPUT ${a_ARCHIVE} DESTINATION ${WORK}/source)
    set(${out} ${WORK}/source/libntp-${VERSION} PARENT_SCOPE)
endfunction()

function(vcpkg_configure_meson)
    cmake_parse_arguments(PARSE_ARGV 0 a "" "SOURCE_PATH" "OPTIONS")
    string(REPLACE dynamic shared linkage ${VCPKG_LIBRARY_LINKAGE})
    run(meson setup ${WORK}/build ${a_SOURCE_PATH} ${a_OPTIONS} -Ddefault_library=${linkage}
        -Dbuildtype=release -Dprefix=${CURRENT_PACKAGES_DIR} -Dlibdir=lib --wrap-mode=nodownload)
endfunction()

function(vcpkg_install_meson)
    run(meson install -C ${WORK}/build)
endfunction()

function(vcpkg_fixup_pkgconfig)
endfunction()

function(vcpkg_copy_pdbs)
endfunction()

function(vcpkg_replace_string path old new)
    file(READ ${path} text)
    string(FIND "${text}" "${old}" at)
    if(at EQUAL -1)
        message(FATAL_ERROR "${path} has no ${old}")
    endif()
    string(REPLACE "${old}" "${new}" text "${text}")
    file(WRITE ${path} "${text}")
endfunction()

function(vcpkg_install_copyright)
    cmake_parse_arguments(PARSE_ARGV 0 a "" "" "FILE_LIST")
    file(COPY ${a_FILE_LIST} DESTINATION ${CURRENT_PACKAGES_DIR}/share/${PORT})
endfunction()

include(${PORTFILE})
