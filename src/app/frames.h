// Which frames a run renders, and what their files are called.
#pragma once
#include <string>
#include <vector>

namespace irradia::app {

/// "1-240", "1-240x4" (every fourth), "7", "1-9,20,30-39", ascending and each once: returns what is wrong, "" if
/// nothing.
std::string read_frames(const std::string& given, std::vector<int>& frames);

/// "2/8": the second of eight shards. As read_frames().
std::string read_shard(const std::string& given, int& shard, int& shards);

/// Frames of a shard: a run of neighbours, which share most records. Every frame is in one shard, and sizes differ by
/// one at most.
std::vector<int> shard_of(const std::vector<int>& frames, int shard, int shards);

/// Has the name a place for the frame: one run of '#'?
bool has_frame_place(const std::string& path);
/// "a.####.exr", 12 -> "a.0012.exr". A path without a place stays as it is.
std::string frame_path(const std::string& path, int frame);

/// "1-3, 7, 9-12".
std::string frames_text(const std::vector<int>& frames);

}  // namespace irradia::app
