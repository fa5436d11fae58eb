#include "python/extension/options.h"

namespace sft::python {

py::object Keywords::taken(const char* name) {
  if (!given_.contains(name)) return py::none();
  py::object value = given_[name];
  PyDict_DelItemString(given_.ptr(), name);
  return value;
}

void Keywords::refuse(const char* name, const py::object& value) {
  throw py::type_error(std::string(name) + " cannot be " + py::repr(value).cast<std::string>());
}

void Keywords::take_transport(TransportChoice& to) {
  std::string name = "automatic";
  take("transport", name);
  if (name == "shm") to = TransportChoice::shm;
  if (name == "udp") to = TransportChoice::udp;
  if (name != "shm" && name != "udp" && name != "automatic")
    throw py::value_error("transport is '" + name + "'; it is 'automatic', 'shm' or 'udp'");
}

void Keywords::refuse_others(const char* function) const {
  for (const auto& [name, value] : given_)
    throw py::type_error(std::string(function) + "() has no argument '" + py::str(name).cast<std::string>() +
                         "'");
}

NodeOptions node_options(const py::dict& given) {
  Keywords keywords(given);
  NodeOptions options;
  keywords.take("name", options.name);
  keywords.take("namespace", options.namespace_);
  keywords.take("remap", options.remap);
  keywords.take("use_sim_time", options.use_sim_time);
  keywords.take("domain", options.domain);
  keywords.take("peers", options.discovery.peers);
  keywords.take("interfaces", options.discovery.interfaces);
  keywords.take("multicast_discovery", options.discovery.multicast);
  keywords.take("daemon_path", options.shm.daemon_path);
  keywords.take("daemon_idle_exit", options.shm.daemon_idle_exit);
  keywords.take_transport(options.transport);
  keywords.refuse_others("Node");
  return options;
}

PublisherOptions publisher_options(const py::dict& given) {
  Keywords keywords(given);
  PublisherOptions options;
  keywords.choose("reliable", options.reliability, Reliability::reliable);
  keywords.choose("transient_local", options.durability, Durability::transient_local);
  keywords.choose("manual_liveliness", options.liveliness, Liveliness::manual_by_topic);
  keywords.take("liveliness_lease", options.liveliness_lease);
  keywords.take("history_depth", options.history_depth);
  keywords.take("deadline", options.deadline);
  keywords.take("lifespan", options.lifespan);
  keywords.take("max_blocking", options.max_blocking);
  keywords.take("max_sample_bytes", options.max_sample_bytes);
  keywords.take("max_bytes_per_s", options.max_bytes_per_s);
  keywords.take("resend_bytes", options.resend_bytes);
  keywords.take("asynchronous", options.asynchronous);
  keywords.take_transport(options.transport);
  keywords.refuse_others("publisher");
  return options;
}

SubscriberOptions subscriber_options(const py::dict& given) {
  Keywords keywords(given);
  SubscriberOptions options;
  keywords.choose("reliable", options.reliability, Reliability::reliable);
  keywords.choose("transient_local", options.durability, Durability::transient_local);
  keywords.choose("manual_liveliness", options.liveliness, Liveliness::manual_by_topic);
  keywords.take("liveliness_lease", options.liveliness_lease);
  keywords.take("depth", options.depth);
  keywords.take("depth_bytes", options.depth_bytes);
  keywords.take("deadline", options.deadline);
  keywords.take("max_rate_hz", options.max_rate_hz);
  keywords.take("max_held", options.max_held);
  keywords.take("further_selections", options.further_selections);
  keywords.take("pollable", options.pollable);
  keywords.take("learn_samples", options.recording.learn_samples);
  keywords.take("narrow_after_samples", options.recording.narrow_after_samples);
  keywords.take("as_remote", options.recording.as_remote);
  keywords.take_transport(options.transport);
  keywords.refuse_others("subscriber");
  return options;
}

}  // namespace sft::python
