#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include <fumarole/renderer.h>
#include <fumarole/scene.h>
#include <fumarole/settings.h>

#include "medium/media_set.h"

namespace fumarole {

/// The last scene that a renderer was given, while its grids go to the GPU a part a frame: until
/// they are there it is drawn with the media of the scene before.
class ComingScene {
public:
    /// Draws a scene from now on, with what it needs sent at once.
    using Show = std::function<void(const Scene&)>;

    explicit ComingScene(medium::MediaSet& media) : media_{media} {}

    /// Bytes a frame.
    void set_limit(std::uint64_t bytes) { limit_ = bytes; }

    [[nodiscard]] bool waits() const { return scene_.has_value(); }
    [[nodiscard]] bool is(const Scene& scene) const;

    /// Waits for a scene's grids, in the place of the one that waited, and sends a part of them.
    /// Grids that are on their way are sent to their end before, or a sequence that is faster would
    /// never get to see any.
    void await(const Scene& scene, const SceneSettings& settings);

    /// Shows the media that are whole: before a frame's first call, as what a host asks of the last
    /// frame after composite() is of the media that were in it.
    void show_what_came(const Show& show);

    /// Sends what the frame may send still.
    void end_frame();

    /// Shows the scene that waits, if one does, with its grids sent at once.
    void finish(const Show& show);

    /// Waits for none any more. What is on its way is sent on: it may be asked for again.
    void drop() { scene_.reset(); }

    /// Waits for none, and sends none.
    void forget();

private:
    void begin_sending(const Scene& scene);
    void send_part();

    medium::MediaSet& media_;
    std::optional<Scene> scene_;
    SceneSettings settings_;
    /// Of a scene: those whose grids are on their way.
    struct Sending {
        std::vector<Medium> media;
        double time = 0;
    };
    std::optional<Sending> sending_;
    std::uint64_t limit_ = Renderer::kUploadLimit, sent_in_frame_ = 0;
};

}  // namespace fumarole
