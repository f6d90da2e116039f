# Install rules of the whole workspace, in two parts round catkin's own:
#   include(install_space.cmake)      before the packages: where it goes, and that it stays there
#   seater_install_interpreter()      after them: which python3 the installed programs run in
# DESTDIR is honoured: `DESTDIR=/tmp/stage cmake --install build` writes below /tmp/stage only.

# catkin writes the prefix into what it installs, so it is chosen here and not by `cmake --install --prefix`.
if(CMAKE_INSTALL_PREFIX_INITIALIZED_TO_DEFAULT)
  set(CMAKE_INSTALL_PREFIX "${CMAKE_CURRENT_SOURCE_DIR}/install" CACHE PATH "Install space" FORCE)
endif()
message(STATUS "seater: the install space is ${CMAKE_INSTALL_PREFIX} and cannot be moved: catkin writes this path into "
  "it. Elsewhere: configure with -DCMAKE_INSTALL_PREFIX=DIR")
install(CODE "
  if(NOT CMAKE_INSTALL_PREFIX STREQUAL \"${CMAKE_INSTALL_PREFIX}\")
    message(FATAL_ERROR
      \"seater: install elsewhere by configuring with -DCMAKE_INSTALL_PREFIX=\${CMAKE_INSTALL_PREFIX}\")
  endif()
  # Whoever builds the repository with an install space inside it does not find its packages twice.
  file(WRITE \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/CATKIN_IGNORE\" \"\")")

# Programs of the install space run in the build's interpreter: catkin leaves "#!/usr/bin/env python3" there, which
# another python3 earlier in PATH would catch.
function(seater_install_interpreter)
  install(CODE "
    file(GLOB programs \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/lib/seater_*/*\")
    foreach(program IN LISTS programs)
      file(READ \"\${program}\" start LIMIT 64)
      if(start MATCHES \"^#!/usr/bin/env python3\")
        file(READ \"\${program}\" text)
        string(REPLACE \"#!/usr/bin/env python3\" \"#!${Python3_EXECUTABLE}\" text \"\${text}\")
        file(WRITE \"\${program}\" \"\${text}\")
      endif()
    endforeach()")
endfunction()
