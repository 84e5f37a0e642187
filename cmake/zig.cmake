# Compiles for another system with the clang of Python's package ziglang: scripts/cross.sh makes the programs in
# ISIMP_ZIG_BIN, and names the target as zig does: x86_64-windows-gnu, aarch64-macos, aarch64-linux-musl.
set(CMAKE_TRY_COMPILE_PLATFORM_VARIABLES ISIMP_ZIG_BIN ISIMP_ZIG_TARGET)
if(ISIMP_ZIG_TARGET MATCHES "windows")
  set(CMAKE_SYSTEM_NAME Windows)
elseif(ISIMP_ZIG_TARGET MATCHES "macos")
  set(CMAKE_SYSTEM_NAME Darwin)
  set(CMAKE_OSX_SYSROOT "") # zig brings its own
  # Its float.h gives either DBL_MAX or NAN, depending on the first header, unless the standard is not a strict one.
  set(CMAKE_CXX_FLAGS_INIT "-include cfloat -U__STRICT_ANSI__")
else()
  set(CMAKE_SYSTEM_NAME Linux)
endif()
string(REGEX REPLACE "-.*" "" CMAKE_SYSTEM_PROCESSOR ${ISIMP_ZIG_TARGET})
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY) # to link is to compile the C++ library first
set(CMAKE_CXX_COMPILER ${ISIMP_ZIG_BIN}/c++)
set(CMAKE_CXX_COMPILER_TARGET ${ISIMP_ZIG_TARGET})
foreach(tool ar ranlib)
  string(TOUPPER CMAKE_${tool} variable)
  set(${variable} ${ISIMP_ZIG_BIN}/${tool} CACHE FILEPATH "" FORCE)
endforeach()
# Nothing of this machine: all headers come by ISIMP_HEADERS and ISIMP_THRUST.
set(CMAKE_FIND_ROOT_PATH ${ISIMP_ZIG_BIN})
foreach(kind LIBRARY PACKAGE)
  set(CMAKE_FIND_ROOT_PATH_MODE_${kind} ONLY)
endforeach()
