#include "sft/node.h"

#include <pybind11/stl.h>

#include <atomic>
#include <condition_variable>
#include <thread>

#include "python/extension/endpoints.h"
#include "python/extension/failure.h"
#include "python/extension/options.h"
#include "python/extension/view.h"

namespace sft::python {

namespace {

constexpr const char* level_names[] = {"debug", "info", "warning", "error"};

LogLevel level_of(const std::string& name) {
  for (const LogLevel level : {LogLevel::debug, LogLevel::info, LogLevel::warning, LogLevel::error})
    if (name == level_names[static_cast<std::size_t>(level)]) return level;
  throw py::value_error("log_level is '" + name + "'; it is 'debug', 'info', 'warning' or 'error'");
}

/// Searches for a type in its own thread. The caller may stop waiting before the search ends, for example
/// at Ctrl-C.
class TypeSearch {
 public:
  static std::shared_ptr<TypeSearch> begin(Node node, std::string topic, std::chrono::nanoseconds timeout) {
    auto search = std::make_shared<TypeSearch>();
    ++threads_without_gil;  // the interpreter must wait for the end of this thread
    std::thread([search, node = std::move(node), topic = std::move(topic), timeout]() mutable {
      search->end(search->find(node, topic, timeout));
      { [[maybe_unused]] const Node closed = std::move(node); }
      --threads_without_gil;
    }).detach();
    return search;
  }
  bool wait(std::chrono::nanoseconds timeout) {
    std::unique_lock lock(mutex_);
    return found_.wait_for(lock, timeout, [this] { return type_.has_value(); });
  }
  Result<DynamicType> result() {
    const std::lock_guard lock(mutex_);
    return *type_;
  }
  /// The caller no longer waits for the result. The search and its node end within `slice`.
  void leave() { has_left_ = true; }

 private:
  using Clock = std::chrono::steady_clock;
  /// The length of one call of Node::find_type(). It is longer than the time in which that function prefers
  /// the types of publishers to those of subscribers, because each call begins this time anew.
  static constexpr std::chrono::nanoseconds slice = std::chrono::seconds(10);

  Result<DynamicType> find(Node& node, const std::string& topic, std::chrono::nanoseconds timeout) {
    const Clock::time_point end = Clock::now() + timeout;
    for (;;) {
      const Clock::time_point slice_end = std::min(Clock::now() + slice, end);
      Result<DynamicType> type = node.find_type(topic, slice_end - Clock::now());
      const Clock::time_point now = Clock::now();
      // Other errors than the end of the slice cannot be corrected by waiting longer.
      if (type || now < slice_end || now >= end || has_left_) return type;
    }
  }
  void end(Result<DynamicType>&& type) {
    const std::lock_guard lock(mutex_);
    type_.emplace(std::move(type));
    found_.notify_all();
  }

  std::mutex mutex_;
  std::condition_variable found_;
  std::optional<Result<DynamicType>> type_;
  std::atomic<bool> has_left_{false};
};

/// Adds a text for Python programs if the error is caused by a fork.
Error for_python(Error error) {
  if (error.message.find("forked") != std::string::npos) error.message += instead_of_fork;
  return error;
}

template <class T>
T opened_or_throw(Result<T>&& result) {
  if (!result) throw Failure(for_python(std::move(result.error())));
  return *std::move(result);
}

}  // namespace

PyNode::PyNode(const py::dict& given, const std::optional<std::string>& log_level) {
  NodeOptions options = node_options(given);
  if (log_level) {
    options.log_level = level_of(*log_level);
    options.log = [callbacks = callbacks_](LogLevel level, std::string_view text) {
      callbacks->put({.kind = level_names[static_cast<std::size_t>(level)], .text = std::string(text)});
    };
  }
  Result<Node> node = fail(Errc::unavailable, "");
  {
    const WithoutGil without;
    node = Node::open(options);
  }
  node_.emplace(opened_or_throw(std::move(node)));
}

const Shared<Node>& PyNode::opened() const {
  refuse_forked();
  if (!node_) throw Failure({Errc::unavailable, "the node is closed"});
  return *node_;
}

Event::Callback PyNode::events(std::uint64_t to) const {
  if (to == 0) return {};
  return [callbacks = callbacks_, to](const Event& event) {
    callbacks->put({.to = to,
                    .kind = to_string(event.kind),
                    .node = event.node,
                    .text = event.text,
                    .count = event.count});
  };
}

std::unique_ptr<PyPublisher> PyNode::publisher(const std::string& topic, const DynamicType& type,
                                               const py::dict& given, std::uint64_t events_to) {
  PublisherOptions options = publisher_options(given);
  options.on_event = events(events_to);
  const Shared<Node> node = opened();
  Result<DynamicPublisher> publisher = fail(Errc::unavailable, "");
  {
    const WithoutGil without;
    publisher = node->publisher(topic, type, options);
  }
  return std::make_unique<PyPublisher>(LockedPublisher(opened_or_throw(std::move(publisher))), node);
}

std::unique_ptr<PySubscriber> PyNode::subscriber(const std::string& topic, const DynamicType& type,
                                                 const std::optional<std::string>& fields,
                                                 const py::dict& given, std::uint64_t events_to) {
  SubscriberOptions options = subscriber_options(given);
  options.on_event = events(events_to);
  const Shared<Node> node = opened();
  Result<DynamicSubscriber> subscriber = fail(Errc::unavailable, "");
  {
    const WithoutGil without;
    subscriber = fields ? node->subscriber(topic, type, *fields, options)
                        : node->subscriber(topic, type, recorded, options);
  }
  return std::make_unique<PySubscriber>(opened_or_throw(std::move(subscriber)), node, topic, !fields,
                                        options.recording.as_remote);
}

DynamicType PyNode::find_type(const std::string& topic, std::optional<double> timeout_s) {
  const auto search = TypeSearch::begin(*opened(), topic, duration_of(timeout_s));
  // The search ends by itself after the timeout, with an error that names the nodes and types that were
  // found.
  try {
    wait_in_slices(
        std::nullopt, [&](std::chrono::nanoseconds time) { return search->wait(time); },
        [] { return false; });
  } catch (...) {
    search->leave();
    throw;
  }
  if (interpreter_ends) throw Failure({Errc::unavailable, "the interpreter ends"});
  return value_of(search->result());
}

py::list PyNode::queued_calls(double timeout_s) {
  std::vector<QueuedCall> calls;
  {
    const WithoutGil without;
    calls = callbacks_->take(duration_of(timeout_s));
  }
  py::list all;
  for (const QueuedCall& call : calls)
    all.append(py::make_tuple(call.to, call.kind, text_of(call.node), text_of(call.text), call.count));
  return all;
}

py::list PyNode::topics() const {
  const Shared<Node> node = opened();
  std::vector<TopicInfo> topics;
  {
    const WithoutGil without;
    topics = node->topics();
  }
  py::list all;
  for (const TopicInfo& topic : topics) {
    for (const TopicInfo::Type& type : topic.types) {
      all.append(py::dict(py::arg("topic") = text_of(topic.name), py::arg("type") = short_name(type.name),
                          py::arg("publishers") = type.publishers,
                          py::arg("subscribers") = type.subscribers));
    }
  }
  return all;
}

void define_endpoints(py::module_& module) {
  py::class_<PyLoan>(module, "Loan")
      .def("get", &PyLoan::get)
      .def("set", &PyLoan::set)
      .def("publish", &PyLoan::publish)
      .def("discard", &PyLoan::discard)
      .def_property_readonly("is_over", &PyLoan::is_over)
      .def_property_readonly("was_copied", &PyLoan::was_copied);
  py::class_<PyPublisher>(module, "Publisher")
      .def("publish", &PyPublisher::publish)
      .def("publish_cdr", &PyPublisher::publish_cdr)
      .def("loan", &PyPublisher::loan)
      .def("wait_for_subscribers", &PyPublisher::wait_for_subscribers)
      .def("assert_liveliness", &PyPublisher::assert_liveliness)
      .def("status", &PyPublisher::status)
      .def("type", &PyPublisher::type)
      .def("close", &PyPublisher::close);
  py::class_<PySubscriber>(module, "Subscriber")
      .def("take", &PySubscriber::take)
      .def("take_latest", &PySubscriber::take_latest)
      .def("wait", &PySubscriber::wait)
      .def("file_descriptor", &PySubscriber::file_descriptor)
      .def("set_selection", &PySubscriber::set_selection)
      .def("set_max_rate_hz", &PySubscriber::set_max_rate_hz)
      .def("requested", &PySubscriber::requested)
      .def("status", &PySubscriber::status)
      .def("held", &PySubscriber::held)
      .def("type", &PySubscriber::type)
      .def("is_over", &PySubscriber::is_over)
      .def("close", &PySubscriber::close);
  py::class_<PyNode>(module, "Node")
      .def(py::init<const py::dict&, const std::optional<std::string>&>())
      .def("publisher", &PyNode::publisher)
      .def("subscriber", &PyNode::subscriber)
      .def("find_type", &PyNode::find_type)
      .def("queued_calls", &PyNode::queued_calls)
      .def("snapshot", &PyNode::snapshot)
      .def("topics", &PyNode::topics)
      .def("now_ns", &PyNode::now_ns)
      .def("interrupt", &PyNode::interrupt)
      .def("is_interrupted", &PyNode::is_interrupted)
      .def("close", &PyNode::close);
}

}  // namespace sft::python
