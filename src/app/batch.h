// --batch: many jobs in one process.
#pragma once
#include "app/options.h"
#include "app/session.h"

namespace irradia::app {

/// Renders the jobs of o.batch, one after the other. Returns the exit status: kSomeFailed if any failed; the log says
/// which, and why. Throws Error for a list that cannot be read, and Stopped.
int run_batch(const Options& o, Session& session);

}  // namespace irradia::app
