// Errors of functions that set something up: a category, on which a program can act, and a sentence that says
// what is wrong and what to do.
//
//   auto node = sft::Node::open(options);
//   if (!node) print(node.error().message);
//
// The other way is Node::open(options).value(), which throws tl::bad_expected_access<sft::Error> if there is
// an error. what() of the exception is the message of the error, which is printed if a program does not
// catch the exception. `*` and `->` end the program with that message, in all builds, and so does value() in
// a program that is compiled with -fno-exceptions. Everything in this header is a plain value.
#pragma once

#include <exception>
#include <functional>
#include <string>
#include <tl/expected.hpp>
#include <type_traits>
#include <utility>

#include "sft/detail/misuse.h"

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

/// @cond not in the reference: Doxygen takes no specialization of a class that it does not know.
/// The exception that value() throws if there is an error. It is the exception of tl::expected with another
/// what(), because that of tl::expected returns the same text for all errors.
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

namespace detail {
/// True if a T can be made from a U, and U is not a Result itself.
template <class U, class T>
concept ValueOf = std::is_constructible_v<T, U> && !requires {
  typename std::remove_cvref_t<U>::unexpected_type;
};
}  // namespace detail

/// A T or an Error. It is a tl::expected, and has the interface of std::expected. But a program that reads
/// the value of a Result with an error, or the error of a Result with a value, ends with a message. With
/// tl::expected, the behaviour would be undefined.
///
/// Larger than usual: there is one function for each kind of reference to a Result.
template <class T>
class Result : public tl::expected<T, Error> {
  using Base = tl::expected<T, Error>;

 public:
  /// Makes a Result with a value-initialized T.
  Result() = default;
  /// Makes a Result with this error, which is usually the result of fail().
  Result(tl::unexpected<Error> error) : Base(std::move(error)) {}
  /// Makes a Result with the value or the error of `other`.
  Result(Base other) : Base(std::move(other)) {}
  /// Makes a Result with the error of `other`, or with a T that is made from its value.
  template <detail::ValueOf<T> U>
  explicit(!std::is_convertible_v<U, T>) Result(tl::expected<U, Error> other)
      : Base(other ? Base(tl::in_place, *std::move(other)) : Base(tl::unexpect, std::move(other).error())) {}
  /// Makes a Result with a T that is made from `value`.
  template <detail::ValueOf<T> U = T>
  explicit(!std::is_convertible_v<U, T>) Result(U&& value) : Base(tl::in_place, std::forward<U>(value)) {}

  /// Returns the value. REQUIRES: there is a value.
  constexpr decltype(auto) operator*() const& { return need_value(), Base::operator*(); }
  /// Gives access to the members of the value. REQUIRES: there is a value.
  constexpr const T* operator->() const { return need_value(), Base::operator->(); }
  /// Returns the error. REQUIRES: there is an error.
  constexpr const Error& error() const& { return need_error(), Base::error(); }

  /// Returns f(value), which must be a Result, if there is a value. Otherwise returns the error.
  template <class F>
  constexpr auto and_then(F&& f) const& {
    return go_on(*this, std::forward<F>(f));
  }
  /// Returns a Result with f(value) if there is a value. Otherwise returns the error.
  template <class F>
  constexpr auto transform(F&& f) const& {
    return checked(Base::transform(std::forward<F>(f)));
  }
  /// Another name of transform().
  template <class F>
  constexpr auto map(F&& f) const& {
    return transform(std::forward<F>(f));
  }
  /// Returns the value if there is a value. Otherwise returns f(error), which must be a Result.
  template <class F>
  constexpr Result or_else(F&& f) const& {
    return this->has_value() ? *this : Result(std::invoke(std::forward<F>(f), error()));
  }
  /// Returns the value if there is a value. Otherwise returns the error f(error).
  template <class F>
  constexpr auto map_error(F&& f) const& {
    return checked(Base::map_error(std::forward<F>(f)));
  }

  /// @cond not in the reference: the same for other kinds of references
  constexpr decltype(auto) operator*() & { return need_value(), Base::operator*(); }
  constexpr decltype(auto) operator*() && { return need_value(), *base(); }
  constexpr T* operator->() { return need_value(), Base::operator->(); }
  constexpr Error& error() & { return need_error(), Base::error(); }
  constexpr Error&& error() && { return need_error(), base().error(); }
  template <class F>
  constexpr auto and_then(F&& f) & {
    return go_on(*this, std::forward<F>(f));
  }
  template <class F>
  constexpr auto and_then(F&& f) && {
    return go_on(std::move(*this), std::forward<F>(f));
  }
  template <class F>
  constexpr auto transform(F&& f) & {
    return checked(Base::transform(std::forward<F>(f)));
  }
  template <class F>
  constexpr auto transform(F&& f) && {
    return checked(base().transform(std::forward<F>(f)));
  }
  template <class F>
  constexpr auto map(F&& f) & {
    return transform(std::forward<F>(f));
  }
  template <class F>
  constexpr auto map(F&& f) && {
    return checked(base().transform(std::forward<F>(f)));
  }
  template <class F>
  constexpr Result or_else(F&& f) && {
    return this->has_value() ? std::move(*this) : Result(std::invoke(std::forward<F>(f), base().error()));
  }
  template <class F>
  constexpr auto map_error(F&& f) && {
    return checked(base().map_error(std::forward<F>(f)));
  }
#ifndef __cpp_exceptions  // the value() of tl::expected is then undefined, too
  constexpr decltype(auto) value() const& { return **this; }
  constexpr decltype(auto) value() & { return **this; }
  constexpr decltype(auto) value() && { return *std::move(*this); }
#endif
  /// @endcond

 private:
  constexpr Base&& base() { return std::move(*this); }

  constexpr void need_value() const {
    if (!this->has_value()) [[unlikely]]
      detail::stop_at_error(Base::error());
  }
  constexpr void need_error() const {
    if (this->has_value()) [[unlikely]]
      detail::stop_at_missing_error();
  }

  template <class Self, class F>
  static constexpr auto go_on(Self&& self, F&& f) {
    const auto call = [&]() -> decltype(auto) {
      if constexpr (std::is_void_v<T>) {
        return std::invoke(std::forward<F>(f));
      } else {
        return std::invoke(std::forward<F>(f), *std::forward<Self>(self));
      }
    };
    using Next = std::remove_cvref_t<decltype(call())>;
    return self.has_value() ? Next(call()) : Next(tl::unexpected<Error>(std::forward<Self>(self).error()));
  }

  template <class U, class E>
  static constexpr auto checked(tl::expected<U, E>&& result) {
    if constexpr (std::is_same_v<E, Error>) {
      return Result<U>(std::move(result));
    } else {
      return std::move(result);
    }
  }
};

/// Makes an error that a function can return as its Result of any type.
inline tl::unexpected<Error> fail(Errc code, std::string message) {
  return tl::unexpected<Error>(Error{code, std::move(message)});
}

}  // namespace sft
