// Errors of set-up calls: a category that a program can act on and a sentence that says what to do.
#pragma once

#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace sft {

enum class Errc {
  invalid_argument,  ///< the caller passed something that can never work
  unknown_field,     ///< a mask or path names a field that the type does not have
  type_mismatch,     ///< bytes or an endpoint of another type
  malformed,         ///< bytes that are not what they claim to be
  limit_exceeded,    ///< larger than a limit in force
  unavailable,       ///< a daemon, device or file that is not there (now)
  no_permission,
  address_in_use,
  out_of_memory,
  system,  ///< the operating system refused, the message says what
};

struct Error {
  Errc code;
  std::string message;  ///< names the thing and what to do about it
};

template <class T>
using Result = tl::expected<T, Error>;

inline tl::unexpected<Error> fail(Errc code, std::string message) {
  return tl::unexpected<Error>(Error{code, std::move(message)});
}

}  // namespace sft
