// Errors of SFT as exceptions of Python. The class sft.Error has the text and the category.
#pragma once

#include <exception>
#include <string>
#include <utility>

#include "sft/result.h"

namespace sft::python {

/// Becomes sft.Error in Python.
class Failure : public std::exception {
 public:
  explicit Failure(Error error) : error_(std::move(error)) {}
  const char* what() const noexcept override { return error_.message.c_str(); }
  const Error& error() const { return error_; }

 private:
  Error error_;
};

/// Sets the exception of Python.
void raise_failure(const Failure& failure);

/// Returns the value, or throws the error.
template <class T>
T value_of(Result<T>&& result) {
  if (!result) throw Failure(std::move(result.error()));
  if constexpr (!std::is_void_v<T>) return *std::move(result);
}

}  // namespace sft::python
