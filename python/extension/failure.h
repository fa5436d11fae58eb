// Converts errors of SFT to exceptions of Python. The Python class is sft.Error, which has the text and the
// category of the error.
#pragma once

#include <exception>
#include <string>
#include <utility>

#include "sft/result.h"

namespace sft::python {

/// An error of SFT as an exception of C++. In Python it becomes an sft.Error.
class Failure : public std::exception {
 public:
  explicit Failure(Error error) : error_(std::move(error)) {}
  const char* what() const noexcept override { return error_.message.c_str(); }
  const Error& error() const { return error_; }

 private:
  Error error_;
};

/// Makes an sft.Error the present exception of Python.
void raise_failure(const Failure& failure);

/// Returns the value. If there is an error instead, throws it as a Failure.
template <class T>
T value_of(Result<T>&& result) {
  if (!result) throw Failure(std::move(result.error()));
  if constexpr (!std::is_void_v<T>) return *std::move(result);
}

}  // namespace sft::python
