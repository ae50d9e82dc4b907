#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "scene_input.h"
#include "window/background.h"
#include <fumarole/asset/scene_file.h>

namespace fumarole::window {

/// A scene on its way in. Files are read on a thread of their own, and what is there already can be
/// shown: camera, lights and procedural media at once, each grid as it is read.
class Document {
public:
    struct News {
        asset::LoadedScene loaded;  ///< whole: with all of its files; else what is there of it
        bool whole = false;
        Scene moving;  ///< whole: with the #s of sequences, for FrameStore
        std::string error;
    };

    /// Starts to read; what was on its way is dropped.
    void open(const command::SceneInput& input);

    /// What has come since the last call: the newest alone.
    std::optional<News> take();

    [[nodiscard]] bool loading() const { return task_.busy(); }
    /// What is being read, in a few words.
    [[nodiscard]] std::string progress() const;
    [[nodiscard]] const command::SceneInput& input() const { return input_; }

private:
    /// Shared with the thread, which may outlive its being wanted.
    struct Mail {
        std::mutex lock;
        std::optional<News> news;
        std::string progress;
    };
    static void read(const command::SceneInput& input, Mail& mail, const Background::Stop& stop);
    static void read_scene(const command::SceneInput& input, Mail& mail,
                           const Background::Stop& stop);

    command::SceneInput input_;
    std::shared_ptr<Mail> mail_ = std::make_shared<Mail>();
    Background task_;
};

}  // namespace fumarole::window
