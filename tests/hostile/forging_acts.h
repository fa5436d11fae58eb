// Acts in the names of honest participants, by datagrams of RTPS, by heartbeats, and with their own control
// messages. Certificates make these acts ineffective. Without certificates, their effects end after the act
// (SECURITY.md).
#pragma once

#include "tests/hostile/act.h"

namespace sft::hostile {

Act forged_disposals(Target& target);
Act forged_deaths(Target& target);
Act requests_with_the_last_number(Target& target);
Act altered_announcements(Target& target);
Act outdated_records(Target& target);
Act impersonated_processes(Target& target);
Act copied_endpoints(Target& target);
Act false_life(Target& target);
Act mutated_control(Target& target);
Act truncated_control(Target& target);
Act replayed_control(Target& target);

}  // namespace sft::hostile
