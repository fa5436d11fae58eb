#include <pybind11/stl.h>

#include <algorithm>
#include <cstring>

#include "python/extension/arrays.h"
#include "python/extension/encoder.h"
#include "python/extension/endpoints.h"
#include "python/extension/failure.h"

namespace sft::python {

namespace {

/// Calls a function with the publisher, without the GIL, after all other threads have finished using the
/// publisher.
template <class Call>
auto alone(LockedPublisher& publisher, Call&& call) {
  refuse_forked();
  const WithoutGil without;
  const std::lock_guard lock(publisher.mutex);
  return call(publisher.publisher);
}

DynamicPublisher::Loan lend(LockedPublisher& publisher, std::size_t bytes) {
  return value_of(alone(publisher, [bytes](DynamicPublisher& p) { return p.loan_cdr(bytes); }));
}

void write(const Plan& plan, DynamicPublisher::Loan& loan, bool zeroed) {
  const WithoutGil without(plan.bytes() > large_bytes);
  plan.write(loan.body(), zeroed);
}

/// Returns false if a reader misses the sample. Throws if nothing was sent.
bool was_sent(Result<PublishStatus>&& result) {
  const PublishStatus status = value_of(std::move(result));
  if (status == PublishStatus::ok || status == PublishStatus::dropped) return status == PublishStatus::ok;
  throw Failure(
      {status == PublishStatus::no_memory ? Errc::out_of_memory : Errc::unavailable, to_string(status)});
}

bool send(LockedPublisher& publisher, DynamicPublisher::Loan&& loan) {
  return was_sent(alone(publisher, [&](DynamicPublisher&) { return std::move(loan).publish(); }));
}

/// Returns the bytes of a received sample that can be published unchanged: it has the publisher's type and
/// all fields. Otherwise returns nothing.
std::span<const std::byte> encoded(const py::handle& message, const DynamicType& type) {
  if (!py::isinstance<Sample>(message)) return {};
  const DynamicSample& sample = message.cast<const Sample&>().held().sample();
  return sample.type().hash() == type.hash() && sample.mask().is_full() ? sample.cdr()
                                                                        : std::span<const std::byte>();
}

}  // namespace

// ---- loans ----

PyLoan::PyLoan(Shared<LockedPublisher> publisher, DynamicPublisher::Loan loan,
               std::vector<Plan::Place> places)
    : publisher_(std::move(publisher)),
      memory_(std::make_shared<DynamicPublisher::Loan>(std::move(loan))),
      places_(std::move(places)) {}

const Plan::Place* PyLoan::find(const std::string& path) const {
  if (memory_ == nullptr)
    throw Failure({Errc::unavailable, "the loan is over: it was published or given back"});
  const auto found = std::ranges::find(places_, path, &Plan::Place::path);
  if (found != places_.end()) return &*found;
  const auto is_below = [&](const Plan::Place& place) { return place.path.starts_with(path + "."); };
  if (std::ranges::any_of(places_, is_below)) return nullptr;
  throw py::key_error("'" + path + "' is no number or array of numbers of this loan");
}

py::object PyLoan::get(const std::string& path) {
  const Plan::Place* const place = find(path);
  if (place == nullptr) return py::none();
  const bool is_single = place->member->shape == Shape::single;
  const py::ssize_t count = static_cast<py::ssize_t>(place->count);
  const py::array array =
      array_over(at(*place), py::dtype(dtype_text(place->member->kind)), {count},
                 {static_cast<py::ssize_t>(bytes_of(place->member->kind))}, keep(memory_), true);
  return is_single ? array.attr("item")(0) : py::object(array);
}

void PyLoan::set(const std::string& path, const py::handle& value) {
  const Plan::Place* const place = find(path);
  if (place == nullptr) throw py::type_error("'" + path + "' is a struct: set its members");
  // The conversion may run Python code that ends the loan. So the memory is accessed only after it.
  if (place->member->shape == Shape::single) {
    const Plan plan = Encoder().member(*place->member, value, path);
    plan.write({at(*find(path)), plan.bytes()}, false);
  } else {
    const py::array fitting = py::module_::import("sft._fit")
                                  .attr("fit_array")(value, py::dtype(dtype_text(place->member->kind)), path);
    const auto count = static_cast<std::size_t>(fitting.size());
    if (count != place->count)
      throw py::value_error("'" + path + "' has " + std::to_string(place->count) + " elements; " +
                            std::to_string(count) + " were given");
    std::byte* const to = at(*find(path));
    const auto kept = memory_;  // another thread may end the loan during this call
    const auto bytes = static_cast<std::size_t>(fitting.nbytes());
    const WithoutGil without(bytes > large_bytes);
    std::memmove(to, fitting.data(), bytes);
  }
}

bool PyLoan::publish() {
  if (memory_ == nullptr) throw Failure({Errc::unavailable, to_string(PublishStatus::no_loan)});
  const std::shared_ptr<DynamicPublisher::Loan> memory = std::exchange(memory_, nullptr);
  was_copied_ = memory.use_count() > 1;
  if (!was_copied_) return send(*publisher_, std::move(*memory));
  // A Python array can still write to the memory of this loan. So a copy is published.
  DynamicPublisher::Loan copy = lend(*publisher_, memory->body().size());
  {
    const WithoutGil without(copy.body().size() > large_bytes);
    std::memcpy(copy.body().data(), memory->body().data(), copy.body().size());
  }
  return send(*publisher_, std::move(copy));
}

// ---- publishers ----

const Shared<LockedPublisher>& PyPublisher::opened() const {
  refuse_forked();
  if (!publisher_) throw Failure({Errc::unavailable, "the publisher is closed"});
  return *publisher_;
}

bool PyPublisher::publish(const py::handle& message) {
  const Shared<LockedPublisher> publisher = opened();
  const DynamicType type = publisher->publisher.type();
  if (const auto bytes = encoded(message, type); !bytes.empty())
    return was_sent(alone(*publisher, [&](DynamicPublisher& p) { return p.publish_cdr(bytes); }));
  const Plan plan = Encoder().message(type.type(), message);
  DynamicPublisher::Loan loan = lend(*publisher, plan.bytes());
  write(plan, loan, false);
  return send(*publisher, std::move(loan));
}

bool PyPublisher::publish_cdr(const py::buffer& payload) {
  const Shared<LockedPublisher> publisher = opened();
  const py::buffer_info info = payload.request();
  const std::span bytes(static_cast<const std::byte*>(info.ptr),
                        static_cast<std::size_t>(info.size * info.itemsize));
  return was_sent(alone(*publisher, [&](DynamicPublisher& p) { return p.publish_cdr(bytes); }));
}

PyLoan PyPublisher::loan(const py::dict& values, bool zeroed) {
  const Shared<LockedPublisher> publisher = opened();
  const DynamicType type = publisher->publisher.type();
  Plan plan = Encoder(true).message(type.type(), values);
  DynamicPublisher::Loan loan = lend(*publisher, plan.bytes());
  write(plan, loan, zeroed);
  return PyLoan(publisher, std::move(loan), plan.take_places());
}

bool PyPublisher::wait_for_subscribers(std::size_t count, std::optional<double> timeout_s) {
  const Shared<LockedPublisher> publisher = opened();
  return wait_in_slices(
      timeout_s,
      [&](std::chrono::nanoseconds time) { return publisher->publisher.wait_for_subscribers(count, time); },
      [this] { return is_over(); });
}

py::dict PyPublisher::status() const {
  const PublisherStatus status = opened()->publisher.status();
  py::list readers;
  for (const PublisherStatus::Reader& reader : status.readers) {
    readers.append(py::dict(py::arg("node") = reader.node, py::arg("served") = reader.served,
                            py::arg("transport") = to_string(reader.transport),
                            py::arg("reason") = reader.reason, py::arg("sent") = reader.sent,
                            py::arg("dropped") = reader.dropped, py::arg("bytes_sent") = reader.bytes_sent,
                            py::arg("bytes_saved") = reader.bytes_saved));
  }
  return py::dict(py::arg("id") = status.id, py::arg("published") = status.published,
                  py::arg("dropped") = status.dropped, py::arg("bytes_sent") = status.bytes_sent,
                  py::arg("bytes_saved") = status.bytes_saved, py::arg("diverted") = status.diverted.total(),
                  py::arg("vanilla_readers") = status.vanilla_readers, py::arg("readers") = readers);
}

}  // namespace sft::python
