#pragma once

#include <stdexcept>
#include <string>

namespace isimp {

/// Base class of all failures of the engine. The message names the problem, its place and the consequence.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The caller's arrays, options or indices can't be used. Nothing was changed. Python sees a ValueError.
class InvalidInput : public Error {
 public:
  using Error::Error;
};

/// A file can't be read or written: missing, of an unknown kind, or damaged. Nothing half-written is left behind.
class FileError : public InvalidInput {
 public:
  using InvalidInput::InvalidInput;
};

/// The job was cancelled from outside. Nothing was changed.
class Cancelled : public Error {
 public:
  Cancelled() : Error("cancelled") {}
};

}  // namespace isimp
