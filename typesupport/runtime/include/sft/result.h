// Errors of set-up calls: a category that a program can act on and a sentence that says what to do.
//
//   auto node = sft::Node::open(options);             // asks: if (!node) print(node.error().message)
//   auto node = sft::Node::open(options).value();     // or throws tl::bad_expected_access<sft::Error>
//
// The exception says what the error says: what() is its message, which is also what a program that does not
// catch it prints when it ends.
#pragma once

#include <exception>
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

/// Why something that was asked for could not be done.
struct Error {
  /// For programs to distinguish.
  Errc code;
  std::string message;  ///< names the thing and what to do about it
};

}  // namespace sft

/// @cond not in the reference: Doxygen takes no specialization of a class that it does not know
/// What value() throws where there is none. It is tl::expected's own exception but for what(), which there is
/// the same for all errors.
template <>
class tl::bad_expected_access<sft::Error> : public std::exception {
 public:
  explicit bad_expected_access(sft::Error error) : error_(std::move(error)) {}

  const char* what() const noexcept override { return error_.message.c_str(); }

  const sft::Error& error() const& { return error_; }
  sft::Error& error() & { return error_; }
  const sft::Error&& error() const&& { return std::move(error_); }
  sft::Error&& error() && { return std::move(error_); }

 private:
  sft::Error error_;
};
/// @endcond

namespace sft {

template <class T>
using Result = tl::expected<T, Error>;

inline tl::unexpected<Error> fail(Errc code, std::string message) {
  return tl::unexpected<Error>(Error{code, std::move(message)});
}

}  // namespace sft
