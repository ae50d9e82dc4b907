# Installs the libraries, builds hosts outside the tree with find_package(fumarole) and with pkg-config,
# and runs them.
#   cmake -DBUILD=... -DSOURCE=... -DWORK=... -DSAMPLE=... -DFLAGS=... -P run.cmake
file(REMOVE_RECURSE ${WORK})
set(prefix ${WORK}/prefix)

function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output
                  ERROR_VARIABLE output)
  if(result EQUAL 77)
    message("skipped, no EGL display without a window here: ${ARGN}")
  elseif(NOT result EQUAL 0)
    message(FATAL_ERROR "${ARGN}\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${prefix})
run(${CMAKE_COMMAND} -S ${SOURCE} -B ${WORK}/build -G Ninja -DCMAKE_PREFIX_PATH=${prefix}
    -DCMAKE_CXX_FLAGS=${FLAGS})
run(${CMAKE_COMMAND} --build ${WORK}/build)

# Nothing but what is under fumarole/ is on a host's include path.
file(GLOB shown ${prefix}/include/*)
if(NOT shown STREQUAL "${prefix}/include/fumarole")
  message(FATAL_ERROR "installed headers: ${shown}")
endif()
file(GLOB_RECURSE headers ${prefix}/include/*.h)
foreach(header ${headers})
  file(READ ${header} text)
  if(text MATCHES "#include [<\"](glad|GL|openvdb|OpenImageIO|nlohmann|assimp)")
    message(FATAL_ERROR "${header} includes ${CMAKE_MATCH_1}")
  endif()
endforeach()

# The library that renders is linked with no reader of files.
file(GLOB_RECURSE library ${prefix}/*/libfumarole.so)
run(objdump -p ${library})
if(output MATCHES "NEEDED +lib(openvdb|OpenImageIO|assimp|OSMesa|EGL|GL|fmt)")
  message(FATAL_ERROR "${library} needs ${CMAKE_MATCH_1}")
endif()
if(NOT output MATCHES "SONAME +libfumarole\\.so\\.[0-9]")
  message(FATAL_ERROR "${library} has no SONAME:\n${output}")
endif()

foreach(host host_glew host_epoxy host_core host_glass "host_glad_asset;${SAMPLE}" "host_static;${SAMPLE}")
  list(POP_FRONT host name)
  run(${WORK}/build/${name} ${host})
  message("${output}")
endforeach()

# An installed folder can be moved, and its program still finds what it opens at run time.
file(RENAME ${prefix} ${WORK}/moved)
run(${WORK}/moved/bin/fumarole render ${SAMPLE} --size 16x16 --aa 1 --bounces 0 -o ${WORK}/moved.exr)
file(RENAME ${WORK}/moved ${prefix})

cmake_path(GET library PARENT_PATH folder)
set(ENV{PKG_CONFIG_PATH} ${folder}/pkgconfig)
run(pkg-config --cflags --libs fumarole-asset)
separate_arguments(flags UNIX_COMMAND "${output} ${FLAGS}")
run(c++ -std=c++20 ${SOURCE}/host_glad.cpp -I${WORK}/build/glad/include ${WORK}/build/libhost_glad.a
    ${flags} -lOSMesa -Wl,-rpath,${folder} -o ${WORK}/host_pkg_config)
run(${WORK}/host_pkg_config ${SAMPLE})
message("by pkg-config: ${output}")
