#include <algorithm>
#include <optional>
#include <utility>

#include "bench/paper/contender.h"
#include "bench/paper/messages.h"
#include "sft/detail/type_description.h"

namespace sft::bench::paper {

namespace {

Reliability reliability(const Contender& contender) {
  return contender.reliable ? Reliability::reliable : Reliability::best_effort;
}

/// Calls the getters of all leaves of a part of a sample.
void read_all(const DynamicView& part) {
  if (part.is_struct()) {
    for (const DynamicView& member : part.members()) read_all(member);
  } else if (part.is_collection() && part.type() != nullptr) {
    for (const DynamicView& element : part.elements()) read_all(element);
  } else {
    (void)static_cast<bool>(part);
  }
}

void read_fields(const DynamicSample& sample, FieldSet fields) {
  for (const DynamicView& member : sample.view().members()) {
    if ((fields & 1) != 0) read_all(member);
    fields >>= 1;
  }
}

class SftReader : public Reader {
 public:
  explicit SftReader(DynamicSubscriber subscriber) : subscriber_(std::move(subscriber)) {}
  bool matched() const override {
    return std::ranges::any_of(subscriber_.status().writers, &SubscriberStatus::Writer::connected);
  }

 private:
  DynamicSubscriber subscriber_;
};

class SftPeer : public Peer {
 public:
  explicit SftPeer(const Contender& contender) : contender_(contender), node_(open(contender)) {}

  std::unique_ptr<Writer> writer(const std::string& topic, const Messages& messages) override {
    return messages.publisher(node_, topic, {.reliability = reliability(contender_)});
  }
  std::unique_ptr<Reader> reader(const std::string& topic, const Messages& messages, FieldSet fields,
                                 Arrived arrived) override {
    const SubscriberOptions options{.reliability = reliability(contender_), .depth = depth};
    const auto type = DynamicType::parse(detail::describe(messages.type().type())).value();
    const FieldSet read = contender_.way == Way::sft_full ? messages.all() : fields;
    auto callback = [read, arrived = std::move(arrived)](const DynamicSample& sample) {
      read_fields(sample, read);
      arrived();
    };
    auto subscriber =
        contender_.way == Way::sft_recorded
            ? node_.subscriber(topic, type, recorded, options, std::move(callback))
            : node_.subscriber(topic, type, messages.text_of(read), options, std::move(callback));
    return std::make_unique<SftReader>(std::move(subscriber).value());
  }

 private:
  /// The hosts have a network of their own each, and one memory together: SFT must not look for it.
  static Node open(const Contender& contender) {
    NodeOptions options{.name = "bench", .transport = TransportChoice::udp};
    if (!contender.multicast) options.udp.multicast = UdpSettings::Multicast::off;
    return Node::open(options).value();
  }

  const Contender contender_;
  Node node_;
};

}  // namespace

std::unique_ptr<Peer> open_sft(const Contender& contender) { return std::make_unique<SftPeer>(contender); }

}  // namespace sft::bench::paper
