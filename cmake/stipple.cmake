# stp_library(NAME SOURCES... LIBRARIES...): a static library with the project's warnings.
set(STP_C_WARNINGS -Wall -Wextra -Wshadow -Wconversion -Wvla -Werror)
set(STP_CXX_WARNINGS -Wall -Wextra -Wshadow -Werror)

function(stp_target_settings target)
    target_include_directories(${target} PUBLIC ${PROJECT_SOURCE_DIR})
    target_compile_definitions(${target} PRIVATE _GNU_SOURCE)
    target_compile_options(${target} PRIVATE
        $<$<COMPILE_LANGUAGE:C>:${STP_C_WARNINGS}>
        $<$<COMPILE_LANGUAGE:CXX>:${STP_CXX_WARNINGS}>)
    # Programs keep what they use of a library alone: a test is a third smaller.
    if(NOT STIPPLE_SANITIZE)
        target_compile_options(${target} PRIVATE -ffunction-sections -fdata-sections)
        target_link_options(${target} PRIVATE -Wl,--gc-sections)
    endif()
    get_target_property(type ${target} TYPE)
    if(STIPPLE_SANITIZE AND type STREQUAL EXECUTABLE)
        target_sources(${target} PRIVATE
            ${PROJECT_SOURCE_DIR}/tests/support/sanitize/keep_loaded.c)
        target_link_options(${target} PRIVATE -Wl,--export-dynamic-symbol=dlclose)
    endif()
endfunction()

function(stp_library target)
    cmake_parse_arguments(ARG "" "" "SOURCES;LIBRARIES" ${ARGN})
    add_library(${target} STATIC ${ARG_SOURCES})
    target_link_libraries(${target} PUBLIC ${ARG_LIBRARIES})
    stp_target_settings(${target})
endfunction()
