// The functions that need OpenImageIO, for a program that is not linked with it. Debian's
// OpenImageIO brings 250 libraries, OpenCV and GDAL among them, whose symbols take the dynamic
// loader a quarter of a second: most of what a command without a picture would take. So it is in a
// module of its own, opened when the first picture is read or an EXR written, or ahead of that in
// the background. A PNG needs none of it.

#include "pictures/ahead.h"
#include "pictures/table.h"

#include <chrono>
#include <cstring>
#include <dlfcn.h>
#include <fmt/format.h>
#include <future>
#include <mutex>
#include <system_error>

#include "asset/printable.h"
#include <fumarole/errors.h>

namespace fumarole {

namespace pictures {

namespace {

namespace fs = std::filesystem;

/// Beside the program where it was built, in the libraries' folder where it is installed. Found
/// from the program's own place, so that an installed folder can be moved.
fs::path module_file()
{
    std::error_code unknown;
    const fs::path folder = fs::read_symlink("/proc/self/exe", unknown).parent_path();
    const fs::path installed = (folder / FUMAROLE_MODULES / kModule).lexically_normal();
    return fs::exists(folder / kModule, unknown) ? folder / kModule : installed;
}

[[noreturn]] void refuse(const fs::path& file, const std::string& problem)
{
    throw Error(fmt::format("{}: {}, and without it no picture is read, nor any but a PNG written; "
                            "install fumarole anew, with all that it needs",
                            file.string(), problem));
}

const Table* open_module()
{
    const fs::path file = module_file();
    std::error_code unknown;
    if (!fs::exists(file, unknown))
        refuse(file, "is not there");
    // Never closed: OpenImageIO's threads and the ends of 250 libraries are in it.
    void* module = ::dlopen(file.c_str(), RTLD_LAZY | RTLD_LOCAL);
    if (module == nullptr)
        refuse(file, "can't be opened: " + asset::printable(::dlerror(), 300));
    const auto get = reinterpret_cast<GetTable>(::dlsym(module, kGetTable));
    if (get == nullptr)
        refuse(file, "is no module of this program");
    const Table* table = get();
    if (std::strcmp(table->version, FUMAROLE_VERSION) != 0)
        refuse(file, fmt::format("is of version {}, the program of {}",
                                 asset::printable(table->version), FUMAROLE_VERSION));
    return table;
}

struct Opening {
    std::once_flag begun;
    std::shared_future<const Table*> table;
};

Opening& begin(std::launch how)
{
    static Opening opening;
    std::call_once(opening.begun, [&] { opening.table = std::async(how, open_module).share(); });
    return opening;
}

const Table& opened()
{
    return *begin(std::launch::deferred).table.get();
}

}  // namespace

void open_ahead()
{
    try {
        begin(std::launch::async);
    } catch (const std::system_error&) {
        // No thread to be had: then it is opened when it is needed.
    }
}

AtEnd::~AtEnd()
{
    const auto& table = begin(std::launch::deferred).table;
    if (table.wait_for(std::chrono::seconds(0)) != std::future_status::deferred)
        table.wait();
}

}  // namespace pictures

namespace asset {

TransparentImage load_image(const std::filesystem::path& file)
{
    return pictures::opened().load_image(file);
}

Environment load_environment(const std::filesystem::path& file)
{
    return pictures::opened().load_environment(file);
}

}  // namespace asset

namespace write {

void write_exr(const Image& image, const std::filesystem::path& file, const ExrOptions& options)
{
    pictures::opened().write_exr(image, file, options);
}

void write_deep_exr(const DeepImage& image, const std::filesystem::path& file,
                    const ExrOptions& options)
{
    pictures::opened().write_deep_exr(image, file, options);
}

Image read_exr(const std::filesystem::path& file, const std::vector<std::string>& channels)
{
    return pictures::opened().read_exr(file, channels);
}

std::vector<std::string> exr_channels(const std::filesystem::path& file)
{
    return pictures::opened().exr_channels(file);
}

bool is_whole(const std::filesystem::path& picture, glm::ivec2 size)
{
    return pictures::opened().is_whole(picture, size);
}

}  // namespace write

}  // namespace fumarole
