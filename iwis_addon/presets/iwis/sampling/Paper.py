import bpy

iwis = bpy.context.scene.iwis

iwis.estimator = "PAPER"
iwis.stop_rule = "PAPER"
iwis.error_threshold = 0.1
iwis.max_samples = 100
iwis.target_samples = 64
iwis.time_limit = 0.0
iwis.batch_size = 8
iwis.coefficients = 0.05
iwis.pixel_filter = "CENTER"
iwis.filter_width = 1.5
iwis.decorrelation = "PIXEL"
