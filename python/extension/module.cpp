// The extension module sft._sft. It is used only by the package python/sft.
#include <pybind11/pybind11.h>

#include <chrono>
#include <thread>

#include "python/extension/endpoints.h"
#include "python/extension/failure.h"
#include "python/extension/gil.h"
#include "python/extension/types.h"
#include "python/extension/view.h"

namespace sft::python {

namespace {

constexpr const char* code_names[] = {"invalid_argument", "unknown_field", "type_mismatch", "malformed",
                                      "limit_exceeded",   "unavailable",   "no_permission", "address_in_use",
                                      "out_of_memory",    "system"};

}  // namespace

void raise_failure(const Failure& failure) {
  const py::object type = py::module_::import("sft._errors").attr("Error");
  const py::object error =
      type(failure.error().message, code_names[static_cast<std::size_t>(failure.error().code)]);
  PyErr_SetObject(type.ptr(), error.ptr());
}

namespace {

/// Waits, for a limited time, for the threads that have released the GIL. Called once when the interpreter
/// begins to end, after all nodes were closed.
void end() {
  using Clock = std::chrono::steady_clock;
  interpreter_ends = true;
  PyThreadState* const state = PyEval_SaveThread();
  const auto last = Clock::now() + std::chrono::seconds(5);
  while (threads_without_gil > 0 && Clock::now() < last)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  PyEval_RestoreThread(state);
}

}  // namespace

}  // namespace sft::python

PYBIND11_MODULE(_sft, module) {
  namespace python = sft::python;
  pybind11::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const python::Failure& failure) {
      python::raise_failure(failure);
    }
  });
  python::define_types(module);
  python::define_views(module);
  python::define_endpoints(module);
  python::define_services(module);
  module.def("end", &python::end);
  module.def("forget_threads", [](bool had_nodes) {  // after fork()
    python::threads_without_gil = 0;
    if (had_nodes) python::is_forked = true;
  });
  module.attr("version") = SFT_VERSION;
  module.attr("knows_numpy_2") = PYBIND11_VERSION_HEX >= 0x020C0000;  // pybind11 2.12
}
