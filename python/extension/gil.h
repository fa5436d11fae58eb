// Releases the GIL while a call waits or copies much data, and handles the end of the interpreter.
//
// No thread of SFT ever takes the GIL, only threads of Python do. So a function that holds the GIL may wait
// for locks of SFT.
#pragma once

#include <pybind11/pybind11.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>

#include "python/extension/failure.h"

namespace sft::python {

namespace py = pybind11;

/// True once the interpreter has begun to end. From then on, no thread releases the GIL: Python would end
/// the thread, including its C++ frames, when the thread requests the GIL again. A process has only one
/// interpreter.
inline std::atomic<bool> interpreter_ends{false};
/// The number of threads that have released the GIL in a call of this module.
inline std::atomic<int> threads_without_gil{0};
/// True in a process that was forked from a process with open nodes. Nothing of SFT may be used there:
/// locks may be held for ever, and waits would return at once.
inline std::atomic<bool> is_forked{false};
/// A text that is added to errors about forks in Python.
inline constexpr const char* instead_of_fork = "; of multiprocessing, use the start method 'spawn'";
/// The size in bytes above which data is copied without the GIL.
constexpr std::size_t large_bytes = 64 * 1024;

inline void refuse_forked() {
  if (!is_forked) return;
  throw Failure({Errc::unavailable, std::string("this process was forked from one that has open nodes: open "
                                                "nodes only after fork()") +
                                        instead_of_fork});
}

/// Releases the GIL of the calling thread as long as this object exists, unless `leaves` is false.
class WithoutGil {
 public:
  explicit WithoutGil(bool leaves = true) {
    if (!leaves || interpreter_ends) return;
    ++threads_without_gil;
    state_ = PyEval_SaveThread();
  }
  WithoutGil(const WithoutGil&) = delete;
  WithoutGil& operator=(const WithoutGil&) = delete;
  ~WithoutGil() {
    if (state_ == nullptr) return;
    PyEval_RestoreThread(state_);
    --threads_without_gil;
  }

 private:
  PyThreadState* state_ = nullptr;
};

/// Returns Python bytes of this size, which `write` fills. `write` gets the memory, and is called without
/// the GIL if the size is large.
template <class Write>
py::bytes bytes_with(std::size_t size, Write&& write) {
  auto bytes =
      py::reinterpret_steal<py::bytes>(PyBytes_FromStringAndSize(nullptr, static_cast<py::ssize_t>(size)));
  if (!bytes) throw py::error_already_set();
  auto* const to = reinterpret_cast<std::byte*>(PyBytes_AS_STRING(bytes.ptr()));
  const WithoutGil without(size > large_bytes);
  write(to);
  return bytes;
}

/// Owns an object of SFT whose destructor may wait for other threads, and destroys this object without the
/// GIL. Copies share the object, as copies of a std::shared_ptr do.
template <class T>
class Shared {
 public:
  explicit Shared(T&& object) : object_(std::make_shared<T>(std::move(object))) {}
  Shared(const Shared&) = default;
  Shared(Shared&&) noexcept = default;
  Shared& operator=(const Shared&) = delete;
  Shared& operator=(Shared&&) = delete;
  ~Shared() { reset(); }

  T* operator->() const { return object_.get(); }
  T& operator*() const { return *object_; }
  /// Ends this reference. REQUIRES: the calling thread has the GIL.
  void reset() {
    if (object_ == nullptr || object_.use_count() > 1) return object_.reset();
    const WithoutGil without;
    object_.reset();
  }

 private:
  std::shared_ptr<T> object_;
};

/// Converts a timeout in seconds that was passed in Python; None means no limit. Throws a ValueError if the
/// timeout is not a number.
inline std::chrono::nanoseconds duration_of(std::optional<double> seconds) {
  constexpr double most_s = 1e9;
  if (seconds && std::isnan(*seconds)) throw py::value_error("timeout is nan; seconds or None were expected");
  return std::chrono::nanoseconds(
      static_cast<std::int64_t>(1e9 * std::clamp(seconds.value_or(most_s), 0.0, most_s)));
}

/// Calls `wait` repeatedly with short timeouts, without the GIL, until it returns true, the time is over,
/// or `is_over` returns true. Between two calls, signal handlers of Python run, so that Ctrl-C ends the
/// wait with an exception.
template <class Wait, class IsOver>
bool wait_in_slices(std::optional<double> timeout_s, Wait&& wait, IsOver&& is_over) {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::nanoseconds slice = std::chrono::milliseconds(100);
  const Clock::time_point end = Clock::now() + duration_of(timeout_s);
  for (;;) {
    refuse_forked();
    const auto left = std::max<std::chrono::nanoseconds>(end - Clock::now(), {});
    bool done = false;
    {
      const WithoutGil without;
      done = wait(std::min(left, slice));
    }
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (done || left <= slice || interpreter_ends || is_over()) return done;
  }
}

}  // namespace sft::python
