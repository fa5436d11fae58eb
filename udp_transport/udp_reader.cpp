#include "udp_transport/udp_reader.h"

#include <utility>

namespace sft::udp {

UdpReader::UdpReader(const core::ReaderSpec& spec, std::shared_ptr<ReceiveLoop> receiver)
    : spec_(spec),
      receiver_(std::move(receiver)),
      inbox_(std::make_shared<Inbox>(spec.depth, spec.listener, spec.depth_bytes)) {
  receiver_->add(spec_);
  receiver_->subscriptions().add(spec.id, inbox_, *spec.type);
}

UdpReader::~UdpReader() {
  receiver_->subscriptions().remove(*inbox_);
  inbox_->detach();
  receiver_->remove(spec_);
}

void UdpReader::share_reader() {
  if (!spec_.only_waited_for) return;
  spec_.only_waited_for = false;
  receiver_->add(spec_);
}

Result<void> UdpReader::connect(const core::Source& source) {
  // Called first, because a reliable sample that comes before this call is not sent again.
  inbox_->connect(source);
  Result<void> connected = receiver_->subscriptions().connect(*inbox_, source);
  if (!connected) inbox_->disconnect(source.writer);
  return connected;
}

void UdpReader::announced(const core::Source& source) {
  receiver_->subscriptions().announced(*inbox_, source);
}

void UdpReader::disconnect(core::EndpointId writer) noexcept {
  inbox_->disconnect(writer);
  receiver_->subscriptions().disconnect(*inbox_, writer);
}

void UdpReader::accept(std::vector<core::Accepted> accepted) {
  receiver_->subscriptions().accept(*inbox_, std::move(accepted));
}

}  // namespace sft::udp
