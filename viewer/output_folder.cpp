#include "output_folder.h"

#include <fmt/format.h>
#include <unistd.h>

#include <fumarole/errors.h>

namespace fumarole::command {

void make_folder(const std::filesystem::path& folder)
{
    std::error_code error, unknown;
    std::filesystem::create_directories(folder, error);
    if (!std::filesystem::is_directory(folder, unknown))
        throw Error(fmt::format("-o: {}: no folder can be made there{}{}", folder.string(),
                                error ? ": " : "", error ? error.message() : ""));
    if (::access(folder.c_str(), W_OK | X_OK) != 0)
        throw Error(fmt::format("-o: {}: no right to write there", folder.string()));
}

}  // namespace fumarole::command
