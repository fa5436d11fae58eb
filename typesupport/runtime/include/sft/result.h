// Errors of functions that set something up: a category, on which a program can act, and a sentence that says
// what is wrong and what to do.
//
//   auto node = sft::Node::open(options);
//   if (!node) print(node.error().message);
//
// The other way is Node::open(options).value(), which throws tl::bad_expected_access<sft::Error> if there is
// an error. what() of the exception is the message of the error, which is printed if a program does not
// catch the exception. In a program that is compiled with -fno-exceptions, value() ends the program without
// a message. Everything in this header is a plain value.
#pragma once

#include <exception>
#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace sft {

/// The category of an error.
enum class Errc {
  invalid_argument,  ///< the caller passed an argument that can never work
  unknown_field,     ///< a mask or path names a field that the type does not have
  type_mismatch,     ///< bytes or an endpoint have another type
  malformed,         ///< bytes are inconsistent, end early, or have another format
  limit_exceeded,    ///< a value exceeds a limit in force
  unavailable,       ///< a daemon, a device or a file is not available at present
  no_permission,
  address_in_use,
  out_of_memory,
  system,  ///< the operating system refused an operation; the message names it
};

/// An error: a category and a message.
struct Error {
  /// The kind of error, for programs.
  Errc code;
  std::string message;  ///< names what failed, and what to do about it
};

}  // namespace sft

/// @cond not in the reference: Doxygen takes no specialization of a class that it does not know The
/// exception that value() throws if there is an error. It is the exception of tl::expected with another
/// what(): that of tl::expected returns the same text for all errors.
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

/// A T or an Error; tl::expected has the interface of std::expected.
template <class T>
using Result = tl::expected<T, Error>;

/// Makes the error that a function returns as its Result.
inline tl::unexpected<Error> fail(Errc code, std::string message) {
  return tl::unexpected<Error>(Error{code, std::move(message)});
}

}  // namespace sft
