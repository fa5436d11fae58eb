// Converts keyword arguments of Python to options of SFT.
#pragma once

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <chrono>
#include <cmath>
#include <string>
#include <utility>

#include "sft/options.h"

namespace sft::python {

namespace py = pybind11;

/// Takes keyword arguments one by one. An argument with the value None counts as not given. A value that
/// the option cannot have raises a TypeError or a ValueError, which names the argument.
class Keywords {
 public:
  explicit Keywords(py::dict given) : given_(std::move(given)) {}

  template <class T>
  void take(const char* name, T& to) {
    const py::object value = taken(name);
    if (value.is_none()) return;
    try {
      to = value.cast<T>();
    } catch (const py::cast_error&) {
      refuse(name, value);
    }
  }
  /// Takes a time in seconds. Times longer than 31 years are refused, because they would overflow.
  template <class Rep, class Period>
  void take(const char* name, std::chrono::duration<Rep, Period>& to) {
    constexpr double most_s = 1e9;
    double seconds = std::chrono::duration<double>(to).count();
    take(name, seconds);
    if (!(std::abs(seconds) <= most_s))
      throw py::value_error(std::string(name) + " is " + std::to_string(seconds) +
                            "; seconds were expected, at most 1e9");
    to = std::chrono::duration_cast<std::chrono::duration<Rep, Period>>(
        std::chrono::duration<double>(seconds));
  }
  /// Takes a boolean. If it is true, sets the option to `if_true`.
  template <class T>
  void choose(const char* name, T& to, T if_true) {
    bool is_true = false;
    take(name, is_true);
    if (is_true) to = if_true;
  }
  void take_transport(TransportChoice& to);
  /// Throws a TypeError that names the arguments that were not taken.
  void refuse_others(const char* function) const;

 private:
  py::object taken(const char* name);
  [[noreturn]] static void refuse(const char* name, const py::object& value);

  py::dict given_;
};

NodeOptions node_options(const py::dict& given);
PublisherOptions publisher_options(const py::dict& given);
SubscriberOptions subscriber_options(const py::dict& given);

}  // namespace sft::python
