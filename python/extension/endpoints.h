// Nodes, publishers, loans and subscribers as the Python package uses them. The classes in
// python/sft/_node.py are those that programs see.
//
// Objects of Python are used by any thread that has the GIL. Publishers let one thread at a time publish.
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

/// A publisher, and the lock by which one thread at a time uses it.
struct LockedPublisher {
  explicit LockedPublisher(DynamicPublisher&& opened) : publisher(std::move(opened)) {}
  LockedPublisher(LockedPublisher&& other) noexcept : publisher(std::move(other.publisher)) {}

  DynamicPublisher publisher;
  std::mutex mutex;  ///< no thread waits for it while it holds the GIL
};

/// A message that is filled in its memory, or a struct of it.
class PyLoan {
 public:
  /// REQUIRES: `loan` has the bytes of the plan.
  PyLoan(Shared<LockedPublisher> publisher, DynamicPublisher::Loan loan, std::vector<Plan::Place> places);

  /// Returns a number, a writable array, or a PyLoan for a struct. Throws `missing` if there is no such
  /// field.
  py::object get(const std::string& path, PyObject* missing) const;
  void set(const std::string& path, const py::handle& value, PyObject* missing);
  /// Publishes it. If an array over it is still alive, a copy is published, and a warning says so.
  bool publish();
  void discard() { lent_->memory.reset(); }
  /// Publishes it at the end of a block, or gives it back after an exception.
  void end(bool failed);

 private:
  struct Lent {
    Shared<LockedPublisher> publisher;
    std::shared_ptr<DynamicPublisher::Loan> memory;  ///< arrays keep it, too; null after the end
    std::vector<Plan::Place> places;
  };

  PyLoan(std::shared_ptr<Lent> lent, std::string prefix)
      : lent_(std::move(lent)), prefix_(std::move(prefix)) {}
  const Plan::Place* find(const std::string& path, PyObject* missing) const;
  std::byte* at(const Plan::Place& place) const { return lent_->memory->body().data() + place.offset; }

  std::shared_ptr<Lent> lent_;
  std::string prefix_{};  ///< of paths: "header.stamp."
};

class PyPublisher {
 public:
  PyPublisher(LockedPublisher&& opened, const Shared<Node>& node)
      : publisher_(std::move(opened)), node_(node) {}

  /// Returns false if a reader misses the sample.
  bool publish(const py::handle& message);
  bool publish_cdr(const py::buffer& payload);
  /// `values` may have numbers of elements in place of sequences.
  PyLoan loan(bool for_overwrite, const py::kwargs& values);
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

  std::optional<Shared<LockedPublisher>> publisher_;  ///< empty once it is closed
  std::optional<Shared<Node>> node_;                  ///< empty once it is closed
};

class PySubscriber {
 public:
  /// `copies`: samples are copied when they are taken, since the options say `as_remote`.
  PySubscriber(DynamicSubscriber&& opened, const Shared<Node>& node, const std::string& topic,
               bool is_recorded, bool copies)
      : subscriber_(std::move(opened)),
        node_(node),
        origin_(std::make_shared<HeldSample::Origin>(topic, is_recorded)),
        copies_(copies) {}

  /// Returns a Sample, or None.
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

  std::optional<Shared<DynamicSubscriber>> subscriber_;  ///< empty once it is closed
  std::optional<Shared<Node>> node_;                     ///< empty once it is closed
  std::shared_ptr<HeldSample::Origin> origin_;
  bool copies_;
};

class PyNode {
 public:
  /// Lines of the log are queued for their callback if `log_level` is given.
  PyNode(const py::dict& options, const std::optional<std::string>& log_level);

  std::unique_ptr<PyPublisher> publisher(const std::string& topic, const DynamicType& type,
                                         const py::dict& options, std::uint64_t events_to);
  std::unique_ptr<PySubscriber> subscriber(const std::string& topic, const DynamicType& type,
                                           const std::optional<std::string>& fields, const py::dict& options,
                                           std::uint64_t events_to);
  DynamicType find_type(const std::string& topic, std::optional<double> timeout_s);
  /// Returns the queued calls of callbacks, each as a tuple. It waits for the first one.
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
  std::optional<Shared<Node>> node_;  ///< empty once it is closed
};

/// Adds the classes to the module.
void define_endpoints(py::module_& module);
void define_services(py::module_& module);

}  // namespace sft::python
