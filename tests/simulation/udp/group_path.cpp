#include "tests/simulation/udp/group_path.h"

#include <algorithm>
#include <chrono>
#include <utility>
#include <vector>

#include "tests/simulation/udp/topic.h"
#include "tests/unit/udp/datagrams.h"

namespace sft::simulation {

void GroupPath::change() {
  if (group_ && happens(random_, 0.3)) {
    group_->is_cut = !group_->is_cut;
  } else if (group_ && happens(random_, 0.3)) {
    group_.reset();
  } else {
    group_.emplace(Group{.number = ++last_number_, .is_cut = happens(random_, 0.1)});
  }
}

void GroupPath::begin_anew() {
  leaving_.clear();
  if (group_) group_.emplace(Group{.number = ++last_number_});
}

void GroupPath::send(const udp::JobHandle& job, Time now) {
  const udp::ResendWindow::Kept kept = channel_.keep(job, group_->membership.hears());
  const std::uint64_t ordinal = ++group_->last_ordinal;
  if (!group_->ahead) group_->ahead = static_cast<std::int64_t>(kept.ordinal - ordinal);
  group_->membership.sent(now);
  job->first.flags |= udp::group_follows;
  job->first.group = {group_->number, static_cast<std::uint32_t>(job->sequence >> 32), ordinal};
  const Time at_once = leaving_.empty() ? now : leaving_.back().at;
  const std::chrono::microseconds waits(happens(random_, 0.5) ? 0 : log_uniform(random_, 20'000));
  const bool lost = group_->is_cut || happens(random_, 0.02);
  leaving_.push_back({std::max(at_once, now + waits), job, kept.elsewhere ? kept.ordinal : 0, lost});
  send_due(now);
}

void GroupPath::send_due(Time now) {
  while (next() <= now) {
    const Leaving leaving = std::move(leaving_.front());
    leaving_.pop_front();
    if (!leaving.lost) send_now(leaving.job, now);
    if (leaving.in_channel != 0) channel_.departed(leaving.in_channel, now);
  }
}

void GroupPath::send_now(const udp::JobHandle& job, Time now) {
  udp::Fragmenter fragments(job->body(), network_.datagram_bytes());
  std::vector<Bytes> datagrams;
  while (!fragments.done()) {
    udp::Batch batch;
    fragments.next(batch, udp::batch_bytes_max, 1);
    udp::test::append_datagrams(batch.parts(), batch.segment_bytes(), datagrams);
  }
  for (Bytes& datagram : datagrams) network_.send(Network::Side::reader, std::move(datagram), now);
}

void GroupPath::offer(Time now) {
  if (!group_ || !group_->ahead) return;
  probe(now);
  group_->membership.look(now);
  if (!group_->membership.offer_due(now)) return;
  const udp::GroupOffer offer{.writer = writer_label,
                              .group = group_->number,
                              .port = writer_port,
                              .address = udp::private_groups + 1,
                              .channel = channel_.number(),
                              .ahead = *group_->ahead};
  Bytes bytes(udp::group_offer_bytes);
  udp::encode(offer, bytes.data());
  network_.send(Network::Side::reader, std::move(bytes), now);
  group_->probes.offered(now);
}

void GroupPath::probe(Time now) {
  if (!group_->probes.due(now) || group_->membership.hears() || group_->is_cut) return;
  Bytes bytes(udp::group_probe_bytes);
  udp::encode(udp::GroupProbe{writer_label, group_->number, group_->last_ordinal}, bytes.data());
  network_.send(Network::Side::reader, std::move(bytes), now);
}

void GroupPath::hear(const udp::GroupReport& report, Time now) {
  if (!group_ || report.group != group_->number) return;
  if (report.heard > group_->last_ordinal) return laws_.fail_unless_forged("a report of what was never sent");
  if (report.heard == 0) return group_->membership.refused(group_->last_ordinal, now);
  group_->membership.reported(report.heard, now);
}

}  // namespace sft::simulation
