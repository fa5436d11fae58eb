// Acts with forged datagrams, which use information from the control topics.
#pragma once

#include "tests/hostile/act.h"

namespace sft::hostile {

Act sequence_jumps(Target& target);
Act sequence_jumps_confirmed(Target& target);
Act heartbeats_from_the_far_future(Target& target);
Act samples_of_sixteen_megabytes(Target& target);
Act begun_samples(Target& target);
Act swept_acks(Target& target);
Act marks_of_made_up_senders(Target& target);
Act marks_for_many_ports(Target& target);
Act group_offers(Target& target);
Act group_reports(Target& target);
Act garbage(Target& target);
Act garbage_for_discovery(Target& target);

}  // namespace sft::hostile
