#include <pybind11/stl.h>

#include "python/extension/endpoints.h"
#include "python/extension/failure.h"

namespace sft::python {

const Shared<DynamicSubscriber>& PySubscriber::opened() const {
  refuse_forked();
  if (!subscriber_)
    throw Failure({Errc::unavailable, "the subscriber of '" + origin_->topic + "' is closed"});
  return *subscriber_;
}

py::object PySubscriber::taken(DynamicSample (DynamicSubscriber::*function)()) {
  const Shared<DynamicSubscriber> subscriber = opened();
  DynamicSample sample = [&] {
    const WithoutGil without(copies_);
    return ((*subscriber).*function)();
  }();
  if (!sample) return py::none();
  return py::cast(Sample(std::make_shared<const HeldSample>(std::move(sample), origin_)));
}

bool PySubscriber::wait(std::optional<double> timeout_s) {
  const Shared<DynamicSubscriber> subscriber = opened();
  return wait_in_slices(
      timeout_s, [&](std::chrono::nanoseconds time) { return subscriber->wait(time); },
      [this] { return is_over(); });
}

void PySubscriber::set_selection(const std::string& fields, std::size_t which) {
  value_of(opened()->set_selection(fields, which));
}

void PySubscriber::set_max_rate_hz(double max_rate_hz, std::size_t which) {
  value_of(opened()->set_max_rate_hz(max_rate_hz, which));
}

py::dict PySubscriber::status(std::size_t which) const {
  const SubscriberStatus status = opened()->status(which);
  py::list writers;
  for (const SubscriberStatus::Writer& writer : status.writers) {
    writers.append(py::dict(py::arg("node") = writer.node, py::arg("connected") = writer.connected,
                            py::arg("transport") = to_string(writer.transport),
                            py::arg("reason") = writer.reason, py::arg("received") = writer.received,
                            py::arg("lost") = writer.lost));
  }
  return py::dict(py::arg("received") = status.received, py::arg("lost") = status.lost,
                  py::arg("withheld") = status.withheld, py::arg("expired") = status.expired,
                  py::arg("discarded") = status.discarded, py::arg("held") = held(),
                  py::arg("held_too_many") = status.held_too_many, py::arg("writers") = writers);
}

}  // namespace sft::python
