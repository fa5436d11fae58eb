#include "core/discovery.h"

#include <dds/dds.h>

#include <array>

#include "core/control_codec.h"
#include "core/dds_domain.h"
#include "core/described_type.h"

namespace sft::core {

namespace {

struct QosDeleter {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};
struct ListenerDeleter {
  void operator()(dds_listener_t* listener) const { dds_delete_listener(listener); }
};
using DdsQos = std::unique_ptr<dds_qos_t, QosDeleter>;
using Listener = std::unique_ptr<dds_listener_t, ListenerDeleter>;

DdsQos control_qos() {
  DdsQos qos(dds_create_qos());
  dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, DDS_MSECS(100));
  dds_qset_durability(qos.get(), DDS_DURABILITY_TRANSIENT_LOCAL);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, 1);
  // A killed node's endpoints must end as "no writers", not as "disposed": only withdrawing disposes of them.
  dds_qset_writer_data_lifecycle(qos.get(), false);
  dds_qset_ignorelocal(qos.get(), DDS_IGNORELOCAL_PARTICIPANT);
  return qos;
}

/// For what is said again and again. Its lease is Cyclone's to watch, and covers all that is written.
DdsQos assertion_qos(const LifeSigns& signs) {
  DdsQos qos(dds_create_qos());
  dds_qset_reliability(qos.get(), DDS_RELIABILITY_BEST_EFFORT, 0);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, 16);
  dds_qset_liveliness(qos.get(), DDS_LIVELINESS_MANUAL_BY_TOPIC, DDS_MSECS(signs.lease.count()));
  dds_qset_writer_data_lifecycle(qos.get(), false);
  dds_qset_ignorelocal(qos.get(), DDS_IGNORELOCAL_PARTICIPANT);
  return qos;
}

/// Requests nothing of the lease, or a node would not hear of those whose own is longer. It is each writer's
/// own lease that Cyclone watches.
DdsQos hearing_qos(const dds_qos_t* written) {
  DdsQos qos(dds_create_qos());
  dds_copy_qos(qos.get(), written);
  dds_qset_liveliness(qos.get(), DDS_LIVELINESS_AUTOMATIC, DDS_INFINITY);
  return qos;
}

/// Others can tell our participants from vanilla ones by it. What changes in it is told to everybody, which
/// is all that `greeting` is for.
DdsQos participant_qos(unsigned greeting) {
  const std::array<char, 6> mark{'s', 'f', 't', '/', '1', static_cast<char>('0' + greeting % 10)};
  DdsQos qos(dds_create_qos());
  dds_qset_userdata(qos.get(), mark.data(), mark.size());
  return qos;
}

/// Takes all that a reader has, in batches, and calls `use(sample, info)`.
template <class Sample, class Use>
void take_all(dds_entity_t reader, Use use) {
  constexpr std::size_t batch = 16;
  std::array<void*, batch> samples{};
  std::array<dds_sample_info_t, batch> infos{};
  for (;;) {
    const dds_return_t n = dds_take(reader, samples.data(), infos.data(), batch, batch);
    if (n <= 0) return;
    for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i) {
      use(*static_cast<const Sample*>(samples[i]), infos[i]);
    }
    dds_return_loan(reader, samples.data(), n);
    samples[0] = nullptr;
  }
}

class CycloneDiscovery final : public Discovery {
 public:
  explicit CycloneDiscovery(DiscoveryListener& listener) : listener_(listener) {}

  ~CycloneDiscovery() override {
    if (participant_ > 0) dds_delete(participant_);  // waits for listeners that run
  }

  Result<void> open(const DiscoveryOptions& options) {
    Result<DdsConfig> config = dds_config(options.domain, options.settings, options.user_config);
    if (!config) return tl::unexpected(config.error());
    if (const auto opened = open_dds_domain(options.domain, *config); !opened) return opened;
    configuration_ = {std::move(config->summary), std::move(config->warnings),
                      config->multicast ? life_signs_to_all : life_signs_to_each};
    const CycloneMessages messages;
    participant_ = dds_create_participant(options.domain, participant_qos(greetings_).get(), nullptr);
    if (participant_ < 0) {
      return fail(Errc::unavailable, "DDS domain " + std::to_string(options.domain) +
                                         " cannot be joined: " + messages.text() +
                                         "; check the network interfaces and CYCLONEDDS_URI");
    }
    const DdsQos qos = control_qos();
    auto endpoints = make_topic(&sft_control_Endpoint_desc, "sft_endpoint", qos.get(), &on_endpoints);
    if (!endpoints) return tl::unexpected(endpoints.error());
    auto requests = make_topic(&sft_control_Request_desc, "sft_request", qos.get(), &on_requests);
    if (!requests) return tl::unexpected(requests.error());
    const DdsQos unreliable = assertion_qos(configuration_.life_signs);
    auto assertions =
        make_topic(&sft_control_Assertion_desc, "sft_liveliness", unreliable.get(), &on_assertions);
    if (!assertions) return tl::unexpected(assertions.error());
    endpoint_writer_ = *endpoints;
    request_writer_ = *requests;
    assertion_writer_ = *assertions;
    return {};
  }

  const Configuration& configuration() const override { return configuration_; }

  Result<void> announce(const Endpoint& endpoint) override {
    ControlStorage storage;
    const sft_control_Endpoint sample = to_dds(endpoint, storage);
    return written(dds_write(endpoint_writer_, &sample));
  }

  void withdraw(EndpointId id) override {
    sft_control_Endpoint key{};
    key.id = id;
    dds_dispose(endpoint_writer_, &key);
    dds_unregister_instance(endpoint_writer_, &key);
    sft_control_Request request_key{};
    request_key.reader = id;
    dds_unregister_instance(request_writer_, &request_key);
  }

  Result<void> send(const Request& request) override {
    const sft_control_Request sample = to_dds(request);
    return written(dds_write(request_writer_, &sample));
  }

  void assert_liveliness(const Assertion& assertion) override {
    ControlStorage storage;
    const sft_control_Assertion sample = to_dds(assertion, storage);
    dds_write(assertion_writer_, &sample);
  }

  void greet() override { dds_set_qos(participant_, participant_qos(++greetings_).get()); }

 private:
  Result<dds_entity_t> make_topic(const dds_topic_descriptor_t* type, const char* name, const dds_qos_t* qos,
                                  dds_on_data_available_fn on_data) {
    const dds_entity_t topic = dds_create_topic(participant_, type, name, qos, nullptr);
    Listener listener(dds_create_listener(this));
    dds_lset_data_available(listener.get(), on_data);
    const dds_entity_t reader =
        topic < 0 ? topic : dds_create_reader(participant_, topic, hearing_qos(qos).get(), listener.get());
    const dds_entity_t writer = reader < 0 ? reader : dds_create_writer(participant_, topic, qos, nullptr);
    if (writer < 0) {
      return fail(Errc::system, std::string("control topic ") + name + ": " + dds_strretcode(writer));
    }
    return writer;
  }

  static Result<void> written(dds_return_t status) {
    if (status == DDS_RETCODE_OK) return {};
    return fail(Errc::system, std::string("a control sample was not written: ") + dds_strretcode(status));
  }

  static void on_endpoints(dds_entity_t reader, void* self) {
    DiscoveryListener& listener = static_cast<CycloneDiscovery*>(self)->listener_;
    take_all<sft_control_Endpoint>(reader,
                                   [&](const sft_control_Endpoint& sample, const dds_sample_info_t& info) {
                                     if (info.valid_data && info.instance_state == DDS_IST_ALIVE) {
                                       endpoint_came(from_dds(sample), listener);
                                     } else if (info.instance_state == DDS_IST_NOT_ALIVE_DISPOSED) {
                                       listener.endpoint_departed(sample.id);
                                     } else if (info.instance_state == DDS_IST_NOT_ALIVE_NO_WRITERS) {
                                       listener.endpoint_lost(sample.id);
                                     }
                                   });
  }

  /// A description that cannot be used costs the endpoint its description and nothing more: programs that
  /// were compiled with the type do not need it.
  static void endpoint_came(Result<Endpoint> endpoint, DiscoveryListener& listener) {
    if (!endpoint) return listener.control_malformed(endpoint.error().message);
    if (!endpoint->type_description.empty()) {
      if (const auto type = described_type(*endpoint); !type) {
        listener.control_malformed(type.error().message);
        endpoint->type_description.clear();
      }
    }
    listener.endpoint_seen(std::move(*endpoint));
  }

  static void on_requests(dds_entity_t reader, void* self) {
    DiscoveryListener& listener = static_cast<CycloneDiscovery*>(self)->listener_;
    take_all<sft_control_Request>(reader,
                                  [&](const sft_control_Request& sample, const dds_sample_info_t& info) {
                                    if (!info.valid_data) return;  // the reader's endpoint tells of its end
                                    Result<Request> request = from_dds(sample);
                                    request ? listener.request_received(std::move(*request))
                                            : listener.control_malformed(request.error().message);
                                  });
  }

  static void on_assertions(dds_entity_t reader, void* self) {
    DiscoveryListener& listener = static_cast<CycloneDiscovery*>(self)->listener_;
    take_all<sft_control_Assertion>(reader,
                                    [&](const sft_control_Assertion& sample, const dds_sample_info_t& info) {
                                      if (!info.valid_data) return listener.node_lost(sample.node);
                                      Result<Assertion> assertion = from_dds(sample);
                                      assertion ? listener.liveliness_asserted(std::move(*assertion))
                                                : listener.control_malformed(assertion.error().message);
                                    });
  }

  DiscoveryListener& listener_;
  Configuration configuration_;
  unsigned greetings_ = 0;
  dds_entity_t participant_ = 0;
  dds_entity_t endpoint_writer_ = 0;
  dds_entity_t request_writer_ = 0;
  dds_entity_t assertion_writer_ = 0;
};

}  // namespace

std::uint32_t control_protocol_version() { return sft_control_protocol_version; }

Result<std::unique_ptr<Discovery>> Discovery::open(const DiscoveryOptions& options,
                                                   DiscoveryListener& listener) {
  auto discovery = std::make_unique<CycloneDiscovery>(listener);
  if (Result<void> opened = discovery->open(options); !opened) return tl::unexpected(opened.error());
  return discovery;
}

}  // namespace sft::core
