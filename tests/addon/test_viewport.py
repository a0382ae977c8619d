"""The rendered view's own object: it lives as long as Blender's engine object for the region."""

from iwis.iwis_addon.viewport import Viewport, living


class Engine:
    """What of Blender's engine object the view's thread knows."""

    def tag_redraw(self):
        pass


def test_a_view_ends_with_its_engine_object():
    # A sleeping thread that held its view would keep the scene of every region ever shown.
    engine = Engine()
    engine.viewport = Viewport(engine)
    thread = engine.viewport.thread
    assert engine.viewport in living()
    assert thread.is_alive()
    del engine
    thread.join(5.0)
    assert not thread.is_alive()
    assert living() == []
