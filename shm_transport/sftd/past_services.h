// RouDi goes on keeping the name of each service that ever had a port: its introspection forgets the ports,
// and not their service. Each publisher of SFT is a service of its own, so each of them would cost the daemon
// 900 bytes for as long as it runs.
#pragma once

#include <iceoryx_posh/internal/roudi/port_manager.hpp>

namespace sft::shm {

/// Forgets the services that have no port any more. Any thread.
void forget_past_services(iox::roudi::PortManager& ports);

}  // namespace sft::shm
