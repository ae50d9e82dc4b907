#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "context/headless_context.h"
#include "gl/device.h"

namespace CLI {
class App;
}

namespace fumarole::command {

/// Where a command draws, as it was typed.
struct DeviceOptions {
    std::string backend = "auto", device;
};

/// `--backend` and `--device`. @param group of the help, or "" for the usual one
void add_device_options(CLI::App& command, DeviceOptions& options, const std::string& group = "");

/// Words that fit together, before anything is loaded. @throws UsageError
void check_device(const DeviceOptions& options);

/// A context, current on this thread. Says on stderr if a GPU fails and the rasteriser takes its
/// place. @throws UsageError if there is no such device; Error as HeadlessContext::make
std::unique_ptr<gl::HeadlessContext> make_context(const DeviceOptions& options);

/// `--backend ...` and `--device ...` where they are not the usual ones, each with a space ahead.
std::string device_text(const DeviceOptions& options);
/// The same as words.
std::vector<std::string> device_words(const DeviceOptions& options);

/// What is drawn with, and why: for the first line of a table.
std::string chosen_text(const gl::HeadlessContext& context, const gl::Device& device);
/// The same for machines: "device", "backend", "device_reason".
nlohmann::ordered_json chosen_json(const gl::HeadlessContext& context, const gl::Device& device);

}  // namespace fumarole::command
