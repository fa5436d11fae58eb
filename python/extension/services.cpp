// Services for the Python package. The package exchanges calls and replies as samples; the rules are here.
#include <pybind11/stl.h>

#include <algorithm>

#include "python/extension/endpoints.h"
#include "python/extension/failure.h"
#include "sft/detail/service_calls.h"

namespace sft::python {

namespace {

using Clock = std::chrono::steady_clock;

/// One call of a service by a client.
class PyClientCall {
 public:
  PyClientCall(const std::string& service, std::optional<double> timeout_s)
      : call_(service, Clock::now(), duration_of(timeout_s)) {}

  std::uint32_t timeout_ms() const { return call_.timeout_ms(); }
  /// Returns the id of the server to which the call must be sent now, or 0, and the time in seconds for
  /// which to wait for the reply. Throws if the call has failed.
  py::tuple next(const PyPublisher& calls, const PySubscriber& replies) {
    using Kind = detail::ClientCall::Step::Kind;
    const Clock::time_point now = Clock::now();
    const auto step = call_.next(now, detail::seen_servers(calls.whole_status(), replies.whole_status()));
    if (step.kind == Kind::fail) throw Failure({Errc::unavailable, step.reason});
    const bool waits = step.kind == Kind::wait;
    const double wait_s = waits ? std::max(std::chrono::duration<double>(step.until - now).count(), 0.0) : 0;
    return py::make_tuple(waits ? 0 : step.server, wait_s);
  }

 private:
  detail::ClientCall call_;
};

/// The calls that a server has already carried out, with their encoded replies.
using Served = detail::ServedCalls<py::bytes>;

}  // namespace

void define_services(py::module_& module) {
  py::class_<PyClientCall>(module, "ClientCall")
      .def(py::init<const std::string&, std::optional<double>>())
      .def("timeout_ms", &PyClientCall::timeout_ms)
      .def("next", &PyClientCall::next);
  module.def("new_client_id", &detail::new_client_id);
  module.def("has_only_server", [](const PyPublisher& calls, const PySubscriber& replies) {
    return detail::only_server(detail::seen_servers(calls.whole_status(), replies.whole_status())) != nullptr;
  });
  py::class_<Served>(module, "ServedCalls")
      .def(py::init())
      .def(
          "is_new",
          [](Served& served, std::uint64_t client, std::uint64_t number) -> py::object {
            const Served::Todo todo = served.heard(client, number, Clock::now());
            return todo == Served::Todo::nothing ? py::object(py::none())
                                                 : py::bool_(todo == Served::Todo::run);
          },
          "True: the handler has to run; False: the reply has to be sent again; None: nothing has to be "
          "done.")
      .def("answered",
           [](Served& served, std::uint64_t client, const py::bytes& reply, std::uint32_t kept_ms) {
             const Clock::time_point now = Clock::now();
             served.answered(client, std::make_unique<py::bytes>(reply), now,
                             now + std::chrono::milliseconds(kept_ms));
           })
      .def("reply", [](Served& served, std::uint64_t client) { return *served.answer(client); });
}

}  // namespace sft::python
