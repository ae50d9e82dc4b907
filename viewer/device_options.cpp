#include "device_options.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "asset/printable.h"
#include "command.h"
#include "shell_words.h"

namespace fumarole::command {

void add_device_options(CLI::App& command, DeviceOptions& options, const std::string& group)
{
    CLI::Option* backend =
        command
            .add_option("--backend", options.backend,
                        "OpenGL without a window: auto is a GPU where there is one that works, "
                        "else OSMesa, the processor [auto]")
            ->check(CLI::IsMember({"auto", "osmesa", "egl"}));
    CLI::Option* device = command.add_option(
        "--device", options.device,
        "of several GPUs: a number or a part of a name, by info --devices [the first that works]");
    device->type_name("N|NAME");
    if (!group.empty()) {
        backend->group(group);
        device->group(group);
    }
}

void check_device(const DeviceOptions& options)
{
    if (!options.device.empty() && options.backend == "osmesa")
        throw UsageError("--device: is for --backend auto or egl; OSMesa is the processor");
}

std::unique_ptr<gl::HeadlessContext> make_context(const DeviceOptions& options)
{
    check_device(options);
    const gl::Backend backend = options.backend == "osmesa" ? gl::Backend::osmesa
                                : options.backend == "egl"  ? gl::Backend::egl
                                                            : gl::Backend::automatic;
    try {
        auto context = gl::HeadlessContext::make({backend, options.device});
        for (const std::string& failure : context->choice().failures)
            fmt::print(stderr, "fumarole: {}; {} is used instead\n",
                       asset::printable(failure, std::string::npos),
                       context->choice().egl_device ? "EGL's rasteriser" : "OSMesa");
        return context;
    } catch (const gl::NoSuchDevice& error) {
        throw UsageError(error.what());
    }
}

std::string device_text(const DeviceOptions& options)
{
    return option_text("--backend", options.backend, "auto") +
           option_text("--device", options.device);
}

std::vector<std::string> device_words(const DeviceOptions& options)
{
    std::vector<std::string> words{"--backend", options.backend};
    if (!options.device.empty())
        words.insert(words.end(), {"--device", options.device});
    return words;
}

std::string chosen_text(const gl::HeadlessContext& context, const gl::Device& device)
{
    return fmt::format("{} by {}", device.capabilities().renderer, context.choice().reason);
}

nlohmann::ordered_json chosen_json(const gl::HeadlessContext& context, const gl::Device& device)
{
    return {{"device", device.capabilities().renderer},
            {"backend", context.name()},
            {"device_reason", context.choice().reason}};
}

}  // namespace fumarole::command
