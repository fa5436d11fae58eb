// Nodes, publishers, loans and subscribers for the Python package. Programs use the classes in
// python/sft/_node.py, which are built on these.
//
// A Python object may be used by any thread that has the GIL. Only one thread at a time uses a publisher.
#pragma once

#include <pybind11/pybind11.h>

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "python/extension/callback_queue.h"
#include "python/extension/gil.h"
#include "python/extension/plan.h"
#include "python/extension/view.h"
#include "sft/node.h"

namespace sft::python {

namespace py = pybind11;

/// A publisher, and the mutex that limits its use to one thread at a time.
struct LockedPublisher {
  explicit LockedPublisher(DynamicPublisher&& opened) : publisher(std::move(opened)) {}
  LockedPublisher(LockedPublisher&& other) noexcept : publisher(std::move(other.publisher)) {}

  DynamicPublisher publisher;
  std::mutex mutex;  ///< a thread must not wait for it while it holds the GIL
};

/// A loaned message, which the program fills in place.
class PyLoan {
 public:
  /// REQUIRES: the body of `loan` has as many bytes as the plan.
  PyLoan(Shared<LockedPublisher> publisher, DynamicPublisher::Loan loan, std::vector<Plan::Place> places);

  /// Returns the value of the field: a number, a writable array, or None for a struct. Throws a KeyError if
  /// there is no such field.
  py::object get(const std::string& path);
  void set(const std::string& path, const py::handle& value);
  /// Publishes the message. If an array over its memory is still alive, publishes a copy instead, and
  /// was_copied() returns true from then on.
  bool publish();
  void discard() { memory_.reset(); }
  bool is_over() const { return memory_ == nullptr; }
  bool was_copied() const { return was_copied_; }

 private:
  const Plan::Place* find(const std::string& path) const;
  std::byte* at(const Plan::Place& place) const { return memory_->body().data() + place.offset; }

  Shared<LockedPublisher> publisher_;
  std::shared_ptr<DynamicPublisher::Loan> memory_;  ///< arrays share it; null after the end of the loan
  std::vector<Plan::Place> places_;
  bool was_copied_ = false;
};

class PyPublisher {
 public:
  PyPublisher(LockedPublisher&& opened, const Shared<Node>& node)
      : publisher_(std::move(opened)), node_(node) {}

  /// Publishes the message. Returns false if a reader misses the sample.
  bool publish(const py::handle& message);
  bool publish_cdr(const py::buffer& payload);
  /// Lends memory for a message. In `values`, a sequence of numbers may be given by its number of elements.
  /// If `zeroed` is true, such sequences are filled with zeros.
  PyLoan loan(const py::dict& values, bool zeroed);
  bool wait_for_subscribers(std::size_t count, std::optional<double> timeout_s);
  void assert_liveliness() { opened()->publisher.assert_liveliness(); }
  py::dict status() const;
  PublisherStatus whole_status() const { return opened()->publisher.status(); }
  DynamicType type() const { return opened()->publisher.type(); }
  bool is_over() const { return !publisher_ || (*node_)->is_interrupted(); }
  void close() {
    publisher_.reset();
    node_.reset();
  }

 private:
  const Shared<LockedPublisher>& opened() const;

  std::optional<Shared<LockedPublisher>> publisher_;  ///< empty after close()
  std::optional<Shared<Node>> node_;                  ///< empty after close()
};

class PySubscriber {
 public:
  /// If `copies` is true, samples are copied when they are taken (the option as_remote).
  PySubscriber(DynamicSubscriber&& opened, const Shared<Node>& node, const std::string& topic,
               bool is_recorded, bool copies)
      : subscriber_(std::move(opened)),
        node_(node),
        origin_(std::make_shared<HeldSample::Origin>(topic, is_recorded)),
        copies_(copies) {}

  /// Returns the next sample as a Sample; None if there is none.
  py::object take() { return taken(&DynamicSubscriber::take); }
  py::object take_latest() { return taken(&DynamicSubscriber::take_latest); }
  bool wait(std::optional<double> timeout_s);
  int file_descriptor() const { return opened()->file_descriptor(); }
  void set_selection(const std::string& fields, std::size_t which);
  void set_max_rate_hz(double max_rate_hz, std::size_t which);
  std::string requested() const { return opened()->requirements().text; }
  py::dict status(std::size_t which) const;
  SubscriberStatus whole_status() const { return opened()->status(); }
  int held() const { return origin_->held; }
  DynamicType type() const { return opened()->type(); }
  bool is_over() const { return !subscriber_ || (*node_)->is_interrupted(); }
  void close() {
    subscriber_.reset();
    node_.reset();
  }

 private:
  const Shared<DynamicSubscriber>& opened() const;
  py::object taken(DynamicSample (DynamicSubscriber::*function)());

  std::optional<Shared<DynamicSubscriber>> subscriber_;  ///< empty after close()
  std::optional<Shared<Node>> node_;                     ///< empty after close()
  std::shared_ptr<HeldSample::Origin> origin_;
  bool copies_;
};

class PyNode {
 public:
  /// If `log_level` is given, lines of the log are queued for their callback.
  PyNode(const py::dict& options, const std::optional<std::string>& log_level);

  std::unique_ptr<PyPublisher> publisher(const std::string& topic, const DynamicType& type,
                                         const py::dict& options, std::uint64_t events_to);
  std::unique_ptr<PySubscriber> subscriber(const std::string& topic, const DynamicType& type,
                                           const std::optional<std::string>& fields, const py::dict& options,
                                           std::uint64_t events_to);
  DynamicType find_type(const std::string& topic, std::optional<double> timeout_s);
  /// Waits for queued calls of callbacks, and returns each of them as a tuple.
  py::list queued_calls(double timeout_s);
  std::string snapshot() const { return to_json(opened()->snapshot()); }
  py::list topics() const;
  std::int64_t now_ns() const { return opened()->now().time_since_epoch().count(); }
  void interrupt() { opened()->interrupt(); }
  bool is_interrupted() const { return !node_ || (*node_)->is_interrupted(); }
  void close() { node_.reset(); }

 private:
  const Shared<Node>& opened() const;
  Event::Callback events(std::uint64_t to) const;

  std::shared_ptr<CallbackQueue> callbacks_ = std::make_shared<CallbackQueue>();
  std::optional<Shared<Node>> node_;  ///< empty after close()
};

/// Adds the classes to the module.
void define_endpoints(py::module_& module);
void define_services(py::module_& module);

}  // namespace sft::python
