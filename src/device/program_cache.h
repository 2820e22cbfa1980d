// Compiled programs of earlier runs, as the driver gives them out: with them a program is ready in a fifth of the time
// that PoCL takes to find its own, which it knows by their preprocessed source.
#pragma once
#include <string>
#include <vector>

#include "core/checksum.h"
#include "device/session.h"

namespace irradia::device {

/// What a compiled program depends on: device, driver, options, and source, by its checksums. Its file is named by the
/// first; the second is in it, so that a clash of names is noticed.
using ProgramKey = Checksums;
ProgramKey program_key(const Session& session, const Checksums& source, const std::string& options);

/// The binary stored under `key`, or shipped: empty if there is none or it is damaged. Shipped ones lie in
/// $IRRADIA_SHIPPED_KERNELS (empty: there are none), else in share/irradia/kernels beside the executable's folder.
std::vector<unsigned char> load_program(const ProgramKey& key);

/// The program of an earlier run, built, which is the caller's to release; null if there is none that the device takes.
cl_program kept_program(const Session& session, const ProgramKey& key, const std::string& options);

/// Is there a folder that programs can be kept in?
bool keeps_programs();

/// Is there a file for `key`?
bool has_program(const ProgramKey& key);

/// Stores the binary of a built program, best after its kernels have run: PoCL compiles them at their first launch.
/// False where it cannot: a run does not depend on it.
///
/// Files lie in $IRRADIA_KERNEL_CACHE (empty: nothing is stored or loaded), else $XDG_CACHE_HOME/irradia/kernels, else
/// ~/.cache/irradia/kernels; each appears whole, so that processes may share the folder.
bool store_program(const ProgramKey& key, cl_program program);

}  // namespace irradia::device
