# What `cmake --install` brings: the program and its modules of images, the manual page, completion for
# bash, what to read; with the renderer also libstipple, its headers and stipple.pc. Nothing of it
# knows where it lies, so it may be installed anywhere and moved as a whole.
set(docs "${CMAKE_INSTALL_DOCDIR}")
# Nothing is installed of a build that is not complete.
set(modules stipple-image stipple-tiff stipple-proj)
if(STIPPLE_MPI)
    list(APPEND modules stipple-mpi)
endif()
set(needed $<TARGET_FILE:stipple> ${PROJECT_BINARY_DIR}/stipple.1)
foreach(module ${modules})
    list(APPEND needed $<TARGET_FILE:${module}>)
endforeach()
if(STIPPLE_RUNTIME)
    list(APPEND needed $<TARGET_FILE:libstipple>)
endif()
install(CODE "foreach(file \"$<JOIN:${needed},\" \">\")
    if(NOT EXISTS \"\${file}\")
        message(FATAL_ERROR \"\${file} is not built yet: run cmake --build '${PROJECT_BINARY_DIR}' first\")
    endif()
endforeach()")
install(TARGETS stipple)
install(TARGETS ${modules} DESTINATION ${CMAKE_INSTALL_LIBDIR}/stipple)
# Pages keep their places, so that their links hold.
install(FILES README.md ARCHITECTURE.md CHANGELOG.md LICENSE DESTINATION ${docs})
install(DIRECTORY docs DESTINATION ${docs} PATTERN plan.md EXCLUDE)
foreach(page formats/SPEC.md shaders/README.md benchmarks/README.md)
    get_filename_component(folder ${page} DIRECTORY)
    install(FILES ${page} DESTINATION ${docs}/${folder})
endforeach()

# Made of the program's own --help.
foreach(kind man bash)
    set(file_man ${PROJECT_BINARY_DIR}/stipple.1)
    set(file_bash ${PROJECT_BINARY_DIR}/stipple.bash)
    add_custom_command(OUTPUT ${file_${kind}}
        COMMAND bash ${PROJECT_SOURCE_DIR}/tools/from-help ${kind} $<TARGET_FILE:stipple>
            > ${file_${kind}}
        DEPENDS stipple ${PROJECT_SOURCE_DIR}/tools/from-help VERBATIM)
endforeach()
add_custom_target(stipple-manual ALL DEPENDS ${file_man} ${file_bash})
install(FILES ${file_man} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(FILES ${file_bash} RENAME stipple
    DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)

if(NOT STIPPLE_RUNTIME)
    return()
endif()

# The headers of stipple.h's interface, which include each other as <stipple/NAME>, and the functions
# they declare, which are all that the library shows.
set(headers "")
set(functions "")
foreach(header runtime/stipple.h runtime/camera/camera.h runtime/gl/gl_context.h base/error.h base/vec_types.h)
    file(READ ${header} text)
    string(REGEX REPLACE "#include \"[a-z/]+/" "#include \"stipple/" text "${text}")
    get_filename_component(name ${header} NAME)
    file(CONFIGURE OUTPUT include/stipple/${name} CONTENT "${text}" @ONLY)
    list(APPEND headers ${PROJECT_BINARY_DIR}/include/stipple/${name})
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${header})
    string(REGEX MATCHALL "stp_[a-z0-9_]+[(]" found "${text}")
    list(APPEND functions ${found})
endforeach()
list(REMOVE_DUPLICATES functions)
list(TRANSFORM functions REPLACE "[(]" "")
list(TRANSFORM functions PREPEND "-Wl,-u," OUTPUT_VARIABLE wanted)
list(JOIN functions "$<SEMICOLON>\n    " names)
set(shown ${PROJECT_BINARY_DIR}/libstipple.map)
file(GENERATE OUTPUT ${shown}
    CONTENT "{\nglobal:\n    ${names}$<SEMICOLON>\nlocal:\n    *$<SEMICOLON>\n}$<SEMICOLON>\n")

# One shared library of the static ones that the program is made of.
file(CONFIGURE OUTPUT libstipple.c CONTENT "/* libstipple is made of static libraries. */\n" @ONLY)
add_library(libstipple SHARED ${PROJECT_BINARY_DIR}/libstipple.c)
target_link_libraries(libstipple PRIVATE stipple-runtime)
target_link_options(libstipple PRIVATE -Wl,--version-script=${shown} ${wanted})
set_target_properties(libstipple PROPERTIES OUTPUT_NAME stipple VERSION ${PROJECT_VERSION}
    SOVERSION ${PROJECT_VERSION_MAJOR} LINK_DEPENDS ${shown} INSTALL_RPATH "" LINKER_LANGUAGE CXX)
install(TARGETS libstipple LIBRARY)
install(FILES ${headers} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/stipple)

file(RELATIVE_PATH prefix /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
configure_file(cmake/stipple.pc.in stipple.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/stipple.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
