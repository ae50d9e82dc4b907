#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "scene.h"

// A scene in time: which camera, which files, at which frame.

namespace fumarole {

/// The camera of a path at a time [s]: on cubics through the keys' positions and targets (Hermite,
/// with the slopes of Catmull and Rom for keys at any times), linear in angle and distances, still
/// before the first key and after the last.
/// @param path not empty, ascending times; projection and `up` are the key's before
Camera camera_at(const std::vector<CameraKey>& path, double time);

/// Whether a file's name has #s, which stand for a frame's number: `smoke_####.vdb`.
bool is_sequence(const std::filesystem::path& file);

/// The file of one frame: the last run of #s in the name becomes the number, with zeros in front as
/// far as the run goes. Anything else stays as it is.
std::filesystem::path frame_file(const std::filesystem::path& file, int frame);

/// Numbers of the frames of a sequence that are there, ascending.
std::vector<int> frames_of(const std::filesystem::path& sequence);

/// The scene at a frame: time is scene.time + frame / frames_per_second, the camera is the path's,
/// and files are the frame's. What was read from a file that is another one now is let go of.
Scene scene_at(const Scene& scene, int frame);

/// Whether a renderer that holds one scene may draw the other from another camera: the same media,
/// lights, surfaces and world, those read from files being the very same.
bool same_content(const Scene& a, const Scene& b);

/// The first frame of the scene's sequences, or nothing if it has none.
std::optional<int> first_frame(const Scene& scene);

}  // namespace fumarole
