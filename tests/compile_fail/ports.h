// Declarations for the snippets about ports and locks.
#pragma once

#include <utility>

#include "core/seam/writer_port.h"
#include "core/sync/lock_order.h"
#include "core/sync/mutex.h"
